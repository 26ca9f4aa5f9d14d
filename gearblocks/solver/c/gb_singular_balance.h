/* Speeds of massless groups where their balance A x = b is singular: n'A = 0 for a row n, which leaves n'b(y) = 0 as a
 * relation of the states y that lasts, so that its rate does: with d(b - A x)/dt = r - S x - A x',
 *     A x = b,   n'S x = n'r   for every n.
 * Two contacts whose damping is clipped and a lossy gear between them: forces are those of springs, and the speed is
 * the one at which they stay in proportion (an index of 2; Hairer and Wanner 1996, Solving ODEs II, ch. VII).
 * Assumed: A on a fixed symmetric pattern. Method: Gauss elimination with both exchanges of [A b S r]; rows that come
 * to nothing go on as [n'S n'r]. Knows nothing of springs and gears. */
#ifndef GB_SINGULAR_BALANCE_H
#define GB_SINGULAR_BALANCE_H

#include "gb_model.h"

#include <math.h>

/* A pivot below this part of its row is none; a relation n'b that is larger than this part of its terms does not hold.
 */
#define GB_NO_PIVOT 1e-11
#define GB_NO_RELATION 1e-6

/* A row of both systems: A x = b and, of its rate, S x = r; size: the largest term that b is made of. */
typedef struct gb_balance_row {
    double *a, *s, b, r, size;
} gb_balance_row;

/* A dense row-major matrix of diag by unknown, lower and upper by place. */
static inline void gb_balance_dense(const gb_pattern *p, const double *entry, double *matrix) {
    const double *lower = entry + p->n, *upper = lower + p->n_places;
    for (int i = 0; i < p->n * p->n; i++) {
        matrix[i] = 0.0;
    }
    for (int k = 0; k < p->n; k++) {
        const int one = p->order[k];
        matrix[one * p->n + one] = entry[k];
        for (int i = p->start[k]; i < p->start[k + 1]; i++) {
            const int other = p->order[p->row[i]];
            matrix[other * p->n + one] = lower[i];
            matrix[one * p->n + other] = upper[i];
        }
    }
}

/* Divides a row by its largest entry. */
static inline void gb_balance_scale(int n, gb_balance_row *row) {
    double largest = 0.0;
    for (int j = 0; j < n; j++) {
        largest = fmax(largest, fabs(row->a[j]));
    }
    for (int j = 0; j < n && largest > 0.0; j++) {
        row->a[j] /= largest;
        row->s[j] /= largest;
    }
    row->b /= largest > 0.0 ? largest : 1.0;
    row->r /= largest > 0.0 ? largest : 1.0;
    row->size = fabs(row->b);
}

/* Row -= factor * pivot row. */
static inline void gb_balance_subtract(int n, gb_balance_row *row, const gb_balance_row *pivot, double factor) {
    for (int j = 0; j < n; j++) {
        row->a[j] -= factor * pivot->a[j];
        row->s[j] -= factor * pivot->s[j];
    }
    row->b -= factor * pivot->b;
    row->r -= factor * pivot->r;
    row->size = fmax(row->size, fabs(factor) * pivot->size);
}

/* Eliminates from step `from` on, by exchanged rows and columns `column`; returns how many steps found a pivot. */
static inline int gb_balance_eliminate(int n, int from, gb_balance_row *rows, int *column) {
    for (int k = from; k < n; k++) {
        int best = k, at = k;
        for (int i = k; i < n; i++) {
            for (int j = k; j < n; j++) {
                if (fabs(rows[i].a[column[j]]) > fabs(rows[best].a[column[at]])) {
                    best = i;
                    at = j;
                }
            }
        }
        if (!(fabs(rows[best].a[column[at]]) > GB_NO_PIVOT)) {
            return k;
        }
        const gb_balance_row row = rows[best];
        const int swap = column[at];
        rows[best] = rows[k];
        rows[k] = row;
        column[at] = column[k];
        column[k] = swap;
        for (int i = k + 1; i < n; i++) {
            gb_balance_subtract(n, &rows[i], &rows[k], rows[i].a[swap] / row.a[swap]);
            rows[i].a[swap] = 0.0;
        }
    }
    return n;
}

/* The row that came to nothing goes on as its rate; 0: its relation does not hold. */
static inline int gb_balance_differentiate(int n, gb_balance_row *row, const gb_balance_row *pivots, const int *column,
                                           int count) {
    const int holds = fabs(row->b) <= GB_NO_RELATION * row->size;
    for (int j = 0; j < n; j++) {
        row->a[j] = row->s[j];
        row->s[j] = 0.0;
    }
    row->b = row->r;
    gb_balance_scale(n, row);
    for (int k = 0; k < count; k++) {
        gb_balance_subtract(n, row, &pivots[k], row->a[column[k]] / pivots[k].a[column[k]]);
        row->a[column[k]] = 0.0;
    }
    return holds;
}

/* Solves for x; entry, rate_entry: A and S by diag, lower, upper; b, r by unknown. 0: these do not tell x. */
static inline int gb_singular_balance(const gb_pattern *p, const double *entry, const double *rate_entry,
                                      const double *b, const double *r, double *x) {
    const int n = p->n;
    double A[n * n], S[n * n];
    gb_balance_row rows[n];
    int column[n], holds = 1;
    gb_balance_dense(p, entry, A);
    gb_balance_dense(p, rate_entry, S);
    for (int i = 0; i < n; i++) {
        rows[i] = (gb_balance_row){A + i * n, S + i * n, b[i], r[i], 0.0};
        gb_balance_scale(n, &rows[i]);
        column[i] = i;
    }
    const int rank = gb_balance_eliminate(n, 0, rows, column);
    for (int i = rank; i < n; i++) {
        holds = gb_balance_differentiate(n, &rows[i], rows, column, rank) && holds;
    }
    if (!holds || gb_balance_eliminate(n, rank, rows, column) < n) {
        return 0;
    }
    for (int k = n - 1; k >= 0; k--) {
        double sum = rows[k].b;
        for (int j = k + 1; j < n; j++) {
            sum -= rows[k].a[column[j]] * x[column[j]];
        }
        x[column[k]] = sum / rows[k].a[column[k]];
    }
    return 1;
}

#endif
