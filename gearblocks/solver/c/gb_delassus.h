/* Delassus matrix  W = G M^-1 G'  of switched constraints, symmetric, and linear systems with the part of it that
 * belongs to a set of them:  W_aa x_a = b_a,  x = 0 outside the set.
 * Two forms. With a pattern: W is sparse, as constraints act on each other only over shafts that they share; the
 * diagonal by constraint, then the lower triangle by places; W_aa = L D L' without exchanges in a fixed order that
 * fills in little, row by row (Davis, Direct methods for sparse linear systems, 2006, section 4.7), rows outside the
 * set as identity. Without one: all n x n numbers, row by row; not symmetric where lossy gears take part. Assumed with
 * a pattern: W_aa is positive definite. Knows nothing of what is active. */
#ifndef GB_DELASSUS_H
#define GB_DELASSUS_H

#include <math.h>
#include <string.h>

/* Unknown order[k] is eliminated in step k = step[order[k]]. Column k of L has the places [start[k], start[k + 1]) in
 * the rows row[place] (steps, ascending); row k of L the columns row_column[] (steps, ascending) in the places
 * row_place[], from row_start[k] to row_start[k + 1]. */
typedef struct gb_symmetric_pattern {
    int n_places;
    const int *order, *step, *start, *row, *row_start, *row_column, *row_place;
} gb_symmetric_pattern;

typedef struct gb_delassus {
    int n;
    const gb_symmetric_pattern *pattern; /* NULL: all numbers */
    const double *value;
} gb_delassus;

/* Numbers of W, and of its factors. */
static inline long gb_delassus_size(int n, const gb_symmetric_pattern *pattern) {
    return pattern ? (long)n + pattern->n_places : (long)n * n;
}

/* Columns and values of row i; returns how many. */
static inline int gb_delassus_row(const gb_delassus *W, int i, int *column, double *value) {
    const gb_symmetric_pattern *p = W->pattern;
    int count = 0;
    if (!p) {
        for (int j = 0; j < W->n; j++) {
            column[j] = j;
            value[j] = W->value[(long)i * W->n + j];
        }
        return W->n;
    }
    const double *lower = W->value + W->n;
    const int k = p->step[i];
    column[count] = i;
    value[count++] = W->value[i];
    for (int at = p->row_start[k]; at < p->row_start[k + 1]; at++) {
        column[count] = p->order[p->row_column[at]];
        value[count++] = lower[p->row_place[at]];
    }
    for (int at = p->start[k]; at < p->start[k + 1]; at++) {
        column[count] = p->order[p->row[at]];
        value[count++] = lower[at];
    }
    return count;
}

/* sum_j W_ij x_j; adds the sizes of its terms to *size. */
static inline double gb_delassus_product(const gb_delassus *W, int i, const double *x, double *size) {
    int column[W->n + 1];
    double value[W->n + 1], sum = 0.0;
    const int count = gb_delassus_row(W, i, column, value);
    for (int k = 0; k < count; k++) {
        const double part = value[k] * x[column[k]];
        sum += part;
        *size += fabs(part);
    }
    return sum;
}

static inline double gb_delassus_diagonal(const gb_delassus *W, int i) {
    return W->pattern ? W->value[i] : W->value[(long)i * W->n + i];
}

/* L D L' of  W_aa + diag(lift)  for the constraints with in[i]: inverse of D by step, L by place. lift: NULL for none.
 */
static inline void gb_delassus_factor(const gb_delassus *W, const int *in, const double *lift, double *factor) {
    const gb_symmetric_pattern *p = W->pattern;
    const double *entry = W->value + W->n;
    double *inverse = factor, *lower = factor + W->n, y[W->n + 1];
    for (int k = 0; k < W->n; k++) {
        const int from = p->row_start[k], to = p->row_start[k + 1], i = p->order[k];
        double pivot = in[i] ? W->value[i] + (lift ? lift[i] : 0.0) : 1.0;
        for (int at = from; at < to; at++) {
            const int j = p->row_column[at];
            y[j] = in[i] && in[p->order[j]] ? entry[p->row_place[at]] : 0.0;
        }
        for (int at = from; at < to; at++) {
            const int j = p->row_column[at];
            const double l = y[j] * inverse[j];
            for (int q = p->start[j]; l != 0.0 && p->row[q] < k; q++) {
                y[p->row[q]] -= lower[q] * y[j];
            }
            pivot -= l * y[j];
            lower[p->row_place[at]] = l;
        }
        inverse[k] = pivot > 0.0 ? 1.0 / pivot : 0.0;
    }
}

/* x becomes the solution; it is 0 outside the set. */
static inline void gb_delassus_solve(int n, const gb_symmetric_pattern *p, const double *factor, double *x) {
    const double *inverse = factor, *lower = factor + n;
    for (int k = 0; k < n; k++) {
        const double known = x[p->order[k]];
        for (int at = p->start[k]; at < p->start[k + 1]; at++) {
            x[p->order[p->row[at]]] -= lower[at] * known;
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        double sum = inverse[k] * x[p->order[k]];
        for (int at = p->start[k]; at < p->start[k + 1]; at++) {
            sum -= lower[at] * x[p->order[p->row[at]]];
        }
        x[p->order[k]] = sum;
    }
}

/* Columns of lossy gears: of their force the partner takes the part skew[j] away again. All numbers. */
static inline void gb_delassus_skew(int n, const int *partner, const double *skew, double *matrix) {
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n && skew[j] != 0.0; i++) {
            matrix[i * n + j] -= skew[j] * matrix[i * n + partner[j]];
        }
    }
}

#endif
