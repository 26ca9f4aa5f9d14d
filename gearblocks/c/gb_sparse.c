/* L D U on a fixed pattern, without pivoting. Knows nothing of steps and models. */
#include "gb_sparse.h"

/* Every column has one entry at most, its parent. */
static void factor_tree(const gb_pattern *restrict p, double *restrict pivot, double *restrict lower,
                        double *restrict upper) {
    const int *restrict start = p->start, *restrict row = p->row;
    for (int k = 0; k < p->n; k++) {
        const int place = start[k];
        pivot[k] = 1.0 / pivot[k];
        if (place < start[k + 1]) {
            const double l = lower[place] * pivot[k];
            pivot[row[place]] -= l * upper[place];
            upper[place] *= pivot[k];
            lower[place] = l;
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

static void solve_tree(const gb_pattern *restrict p, const double *restrict inverse, const double *restrict lower,
                       const double *restrict upper, double *restrict w) {
    const int *restrict start = p->start, *restrict row = p->row;
    for (int k = 0; k < p->n; k++) {
        const int place = start[k];
        if (place < start[k + 1]) {
            w[row[place]] -= lower[place] * w[k];
        }
    }
    for (int k = p->n - 1; k >= 0; k--) {
        const int place = start[k];
        w[k] *= inverse[k];
        if (place < start[k + 1]) {
            w[k] -= upper[place] * w[row[place]];
        }
    }
}

static void solve_general(const gb_pattern *restrict p, const double *restrict inverse, const double *restrict lower,
                          const double *restrict upper, double *restrict w) {
    const int *restrict start = p->start, *restrict row = p->row;
    for (int k = 0; k < p->n; k++) {
        for (int place = start[k]; place < start[k + 1]; place++) {
            w[row[place]] -= lower[place] * w[k];
        }
    }
    for (int k = p->n - 1; k >= 0; k--) {
        double sum = w[k] * inverse[k];
        for (int place = start[k]; place < start[k + 1]; place++) {
            sum -= upper[place] * w[row[place]];
        }
        w[k] = sum;
    }
}

void gb_solve(const gb_pattern *p, const double *inverse, const double *lower, const double *upper, const double *b,
              double *work, double *x) {
    for (int k = 0; k < p->n; k++) {
        work[k] = b[p->order[k]];
    }
    (p->tree ? solve_tree : solve_general)(p, inverse, lower, upper, work);
    for (int k = 0; k < p->n; k++) {
        x[p->order[k]] = work[k];
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

/* Backwards through the elimination, so that all neighbours with a colour stand in the column. */
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
