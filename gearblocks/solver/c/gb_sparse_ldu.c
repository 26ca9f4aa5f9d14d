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

/* Every column has one entry at most, its parent. Along runs only a division and a difference follow on each other. */
static void factor_tree(const gb_pattern *p, double *restrict pivot, double *restrict lower, double *restrict upper) {
    const int *start = p->start, *row = p->row;
    const gb_pair one = {1.0, 1.0};
    int k = 0;
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

static void factor_general(const gb_pattern *restrict p, double *restrict pivot, double *restrict lower,
                           double *restrict upper) {
    const int *restrict pair = p->pair;
    for (int k = 0; k < p->n; k++) {
        const int from = p->start[k], to = p->start[k + 1];
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

int gb_factor(const gb_pattern *p, double scale, const double *diag, double *lower, double *upper, double *inverse) {
    for (int k = 0; k < p->n; k++) {
        inverse[k] = diag[p->order[k]];
    }
    (p->tree ? factor_tree : factor_general)(p, inverse, lower, upper);
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
    int k = 0;
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
    int k = p->n - 1;
    while (k >= 0) {
        const int place = p->start[k];
        if (k >= 3 && p->start[k - 3] == place - 3 && in_run(p, k - 3, place - 3)) {
            gb_pair last = pair_at(w + k + 1);
            int at = place - 3;
            do {
                k -= 4;
                const gb_pair u0 = pair_at(upper + at), u2 = pair_at(upper + at + 2);
                const gb_pair w0 = pair_at(w + k + 1) * pair_at(inverse + k + 1);
                const gb_pair w2 = pair_at(w + k + 3) * pair_at(inverse + k + 3), x2 = w2 - u2 * last;
                last = (w0 - u0 * w2) + (u0 * u2) * last;
                put(w + k + 1, last);
                x[order[k + 1]] = last[0];
                x[order[k + 2]] = last[1];
                x[order[k + 3]] = x2[0];
                x[order[k + 4]] = x2[1];
                put(w + k + 3, x2);
                at -= 4;
            } while (k >= 3 && p->start[k - 3] == at && in_run(p, k - 3, at));
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

static void solve_general(const gb_pattern *restrict p, const double *restrict inverse, const double *restrict lower,
                          const double *restrict upper, double *restrict w, double *restrict x) {
    for (int k = 0; k < p->n; k++) {
        for (int place = p->start[k]; place < p->start[k + 1]; place++) {
            w[p->row[place]] -= lower[place] * w[k];
        }
    }
    for (int k = p->n - 1; k >= 0; k--) {
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
        solve_general(p, inverse, lower, upper, work, x);
    }
}

long gb_pair_count(const gb_pattern *p) {
    long count = 0;
    for (int k = 0; k < p->n; k++) {
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
