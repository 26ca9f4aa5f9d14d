#include "gb_sparse_ldu.h"

/* Two neighbouring entries. The same operations in the same order on every machine. */
typedef double gb_pair __attribute__((vector_size(2 * sizeof(double)), aligned(sizeof(double)), may_alias));

static inline gb_pair pair_at(const double *x) {
    return *(const gb_pair *)(const void *)x;
}

static inline void put(double *x, gb_pair value) {
    *(gb_pair *)(void *)x = value;
}

/* Do four columns from k of a tree, whose entries begin at `place`, each have one entry, two rows on? A chain that is
 * eliminated from both ends is made of these. */
static inline int in_run(const gb_pattern *p, int k, int place) {
    const int *row = p->row + place;
    return k + 6 <= p->n && p->start[k + 4] == place + 4 &&
           ((row[0] ^ (k + 2)) | (row[1] ^ (k + 3)) | (row[2] ^ (k + 4)) | (row[3] ^ (k + 5))) == 0;
}

/* Unknowns that nothing reads: rows of U alone. */
static void factor_ahead(const gb_pattern *p, double *restrict pivot, double *restrict upper) {
    for (int k = 0; k < p->ahead; k++) {
        pivot[k] = 1.0 / pivot[k];
        for (int place = p->start[k]; place < p->start[k + 1]; place++) {
            upper[place] *= pivot[k];
        }
    }
}

/* The unknown of step k is `gain` times that of row[at]: its row and its column are added to those, and it follows. */
static void tie(const gb_pattern *p, int k, int at, double gain, double *restrict pivot, double *restrict lower,
                double *restrict upper, const int *restrict pair) {
    const int from = p->start[k], to = p->start[k + 1];
    pivot[p->row[at]] += gain * (lower[at] + upper[at]) + gain * gain * pivot[k];
    for (int a = from; a < to; a++) {
        for (int b = a + 1; b < to; b++, pair++) {
            if (a == at) {
                lower[*pair] += gain * lower[b];
                upper[*pair] += gain * upper[b];
            } else if (b == at) {
                lower[*pair] += gain * upper[a];
                upper[*pair] += gain * lower[a];
            }
        }
    }
    for (int a = from; a < to; a++) {
        lower[a] = upper[a] = a == at ? -gain : 0.0;
    }
    pivot[k] = 0.0;
}

/* Every column has one entry at most, its parent. Along runs only a division and a difference follow on each other. */
static void factor_tree(const gb_pattern *p, double *restrict pivot, double *restrict lower, double *restrict upper) {
    const int *start = p->start, *row = p->row;
    const gb_pair one = {1.0, 1.0};
    int k = p->ahead;
    while (k < p->n) {
        int place = start[k];
        if (in_run(p, k, place)) {
            gb_pair last = pair_at(pivot + k);
            do {
                const gb_pair l = pair_at(lower + place), u = pair_at(upper + place), inverse = one / last;
                last = pair_at(pivot + k + 2) - (l * u) / last;
                put(pivot + k, inverse);
                put(lower + place, l * inverse);
                put(upper + place, u * inverse);
                k += 2;
                place += 2;
            } while (in_run(p, k, place));
            put(pivot + k, last);
        } else {
            pivot[k] = 1.0 / pivot[k];
            if (place < start[k + 1]) {
                const double l = lower[place] * pivot[k];
                pivot[row[place]] -= l * upper[place];
                upper[place] *= pivot[k];
                lower[place] = l;
            }
            k++;
        }
    }
}

static void factor_general(const gb_pattern *restrict p, const gb_ties *ties, double *restrict pivot,
                           double *restrict lower, double *restrict upper) {
    const int *restrict pair = p->pair;
    for (int k = p->ahead; k < p->n; k++) {
        const int from = p->start[k], to = p->start[k + 1];
        if (ties && ties->place[k] >= 0) {
            tie(p, k, ties->place[k], ties->gain[k], pivot, lower, upper, pair);
            pair += (to - from) * (to - from - 1) / 2;
            continue;
        }
        pivot[k] = 1.0 / pivot[k];
        for (int a = from; a < to; a++) {
            const double l = lower[a] * pivot[k], u = upper[a] * pivot[k];
            pivot[p->row[a]] -= l * upper[a];
            for (int b = a + 1; b < to; b++) {
                lower[*pair] -= lower[b] * u;
                upper[*pair] -= l * upper[b];
                pair++;
            }
        }
        for (int a = from; a < to; a++) {
            lower[a] *= pivot[k];
            upper[a] *= pivot[k];
        }
    }
}

int gb_factor(const gb_pattern *p, const gb_ties *ties, double scale, const double *diag, double *lower, double *upper,
              double *inverse) {
    for (int k = 0; k < p->n; k++) {
        inverse[k] = diag[p->order[k]];
    }
    factor_ahead(p, inverse, upper);
    if (p->tree && !ties) {
        factor_tree(p, inverse, lower, upper);
    } else {
        factor_general(p, ties, inverse, lower, upper);
    }
    int bad = -1;
    for (int k = p->n - 1; k >= 0; k--) {
        bad = inverse[k] - inverse[k] == 0.0 ? bad : k;
        inverse[k] *= scale;
    }
    return bad < 0 ? -1 : p->order[bad];
}

/* In runs two links are taken at once, so that each waits for half as many results: w4 - l2 (w2 - l0 w0) as
 * (w4 - l2 w2) + (l2 l0) w0. */
static void forward_tree(const gb_pattern *p, const double *restrict lower, double *restrict w) {
    int k = p->ahead;
    while (k < p->n) {
        int place = p->start[k];
        if (in_run(p, k, place)) {
            gb_pair last = pair_at(w + k);
            do {
                const gb_pair l0 = pair_at(lower + place), l2 = pair_at(lower + place + 2), w2 = pair_at(w + k + 2);
                put(w + k + 2, w2 - l0 * last);
                last = (pair_at(w + k + 4) - l2 * w2) + (l2 * l0) * last;
                put(w + k + 4, last);
                k += 4;
                place += 4;
            } while (in_run(p, k, place));
        } else {
            if (place < p->start[k + 1]) {
                w[p->row[place]] -= lower[place] * w[k];
            }
            k++;
        }
    }
}

static void backward_tree(const gb_pattern *p, const double *restrict inverse, const double *restrict upper,
                          double *restrict w, double *restrict x) {
    const int *order = p->order;
    const int last = p->ahead + 3;
    int k = p->n - 1;
    while (k >= p->ahead) {
        const int place = p->start[k];
        if (k >= last && p->start[k - 3] == place - 3 && in_run(p, k - 3, place - 3)) {
            gb_pair behind = pair_at(w + k + 1);
            int at = place - 3;
            do {
                k -= 4;
                const gb_pair u0 = pair_at(upper + at), u2 = pair_at(upper + at + 2);
                const gb_pair w0 = pair_at(w + k + 1) * pair_at(inverse + k + 1);
                const gb_pair w2 = pair_at(w + k + 3) * pair_at(inverse + k + 3), x2 = w2 - u2 * behind;
                behind = (w0 - u0 * w2) + (u0 * u2) * behind;
                put(w + k + 1, behind);
                x[order[k + 1]] = behind[0];
                x[order[k + 2]] = behind[1];
                x[order[k + 3]] = x2[0];
                x[order[k + 4]] = x2[1];
                put(w + k + 3, x2);
                at -= 4;
            } while (k >= last && p->start[k - 3] == at && in_run(p, k - 3, at));
        } else {
            w[k] *= inverse[k];
            if (place < p->start[k + 1]) {
                w[k] -= upper[place] * w[p->row[place]];
            }
            x[order[k]] = w[k];
            k--;
        }
    }
}

static void forward_general(const gb_pattern *restrict p, const double *restrict lower, double *restrict w) {
    for (int k = p->ahead; k < p->n; k++) {
        for (int place = p->start[k]; place < p->start[k + 1]; place++) {
            w[p->row[place]] -= lower[place] * w[k];
        }
    }
}

/* The unknowns of the steps before `from`, down to step `to`. */
static void backward_general(const gb_pattern *restrict p, int from, int to, const double *restrict inverse,
                             const double *restrict upper, double *restrict w, double *restrict x) {
    for (int k = from - 1; k >= to; k--) {
        double sum = w[k] * inverse[k];
        for (int place = p->start[k]; place < p->start[k + 1]; place++) {
            sum -= upper[place] * w[p->row[place]];
        }
        w[k] = sum;
        x[p->order[k]] = sum;
    }
}

void gb_solve(const gb_pattern *p, const double *inverse, const double *lower, const double *upper, const double *b,
              double *work, double *x) {
    for (int k = 0; k < p->n; k++) {
        work[k] = b[p->order[k]];
    }
    if (p->tree) {
        forward_tree(p, lower, work);
        backward_tree(p, inverse, upper, work, x);
    } else {
        forward_general(p, lower, work);
        backward_general(p, p->n, p->ahead, inverse, upper, work, x);
    }
    backward_general(p, p->ahead, 0, inverse, upper, work, x);
}

long gb_pair_count(const gb_pattern *p) {
    long count = 0;
    for (int k = p->ahead; k < p->n; k++) {
        const long entries = p->start[k + 1] - p->start[k];
        count += entries * (entries - 1) / 2;
    }
    return count;
}

int gb_colour_count(const gb_pattern *p) {
    int most = 0;
    for (int k = 0; k < p->n; k++) {
        const int count = p->start[k + 1] - p->start[k];
        most = count > most ? count : most;
    }
    return most + 1;
}

void gb_colours(const gb_pattern *p, int *colour) {
    for (int k = p->n - 1; k >= 0; k--) {
        int mine = 0;
        for (int place = p->start[k]; place < p->start[k + 1]; place++) {
            if (colour[p->order[p->row[place]]] == mine) {
                mine++;
                place = p->start[k] - 1;
            }
        }
        colour[p->order[k]] = mine;
    }
}
