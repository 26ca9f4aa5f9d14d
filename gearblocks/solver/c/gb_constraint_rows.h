/* Rows G of switched velocity constraints  G v + g(t) = 0  and the reduction of those of the active set: one after the
 * other by those before, each solved for one speed, its pivot (the largest coefficient that is left); a row that
 * follows from those before is redundant. From the last row to the first the pivots follow from the other speeds.
 * Source: Gaussian elimination row by row, without the way back: rows stay as short as they can.
 * Knows nothing of forces.
 *
 * The active set lies behind the modes, as doubles: count, indices, redundancy. Behind it lies what follows from it,
 * which is not saved with a state: reduced rows, factors of W (gb_delassus.h), room. */
#ifndef GB_CONSTRAINT_ROWS_H
#define GB_CONSTRAINT_ROWS_H

#include "gb_inline.h"
#include "gb_lcp.h"
#include "gb_model.h"

/* Rows: entries [start[i], start[i + 1]) lie in the columns column[]; column c is speed[c]. Reduced rows have up to
 * n_reduced entries besides their pivots; n_factors of the reduction are kept (0: no slip has a bias). shares: there
 * are lossy gears, so that forces of redundant rows are felt (gb_active_set.h). */
typedef struct gb_constraint_rows {
    int n, n_columns, n_speeds, n_reduced, n_factors, shares;
    const int *start, *column, *speed;
    const gb_symmetric_pattern *pattern;
} gb_constraint_rows;

/* Offsets in the active set of n constraints, and its length. */
enum { GB_ACTIVE_COUNT = 0, GB_ACTIVE_INDEX = 1 };
static inline int gb_active_redundant(int n) {
    return 1 + n;
}
static inline int gb_active_saved(int n) {
    return 1 + 2 * n;
}

/* An active set in memory. Of n_rows reduced rows row r is that of constraint of[r], with the entries start[r] ..
 * start[r
 * + 1]; the factors of the rows before that were taken off it are factor_start[r] .. factor_start[r + 1], then it was
 * multiplied with scale[r]. As ties (n_roots >= 0): root[q] and what follows it, speed tied[e] with tie_gain[e] from
 * tie_start[q] to tie_start[q + 1], then n_held that are at rest; inverse inertias by speed. Of a few speeds
 * (has_answer) also the accelerations per torque on each, in columns of GB_PAD. Of n_shared redundant rows shared[d]
 * has the forces of the independent ones times share[d * n ..]. */
typedef struct gb_active_set {
    double *count, *index, *redundant;
    double *value, *factor, *scale, *tie_gain, *inverse_mass, *answer, *inverse, *share, *room, *matrix;
    int *n_rows, *n_roots, *n_held, *has_answer, *n_shared, *shared, *of, *pivot, *start, *column, *factor_start,
        *factor_row, *root, *tie_start, *tied;
} gb_active_set;

static inline double *gb_active_take(double **at, long count) {
    double *here = *at;
    *at += count;
    return here;
}

/* The active set that begins at `base`; returns its length with all that is behind it. `carried`: up to where a copy
 * needs it. */
GB_INLINE long gb_active_lay(const gb_constraint_rows *rows, double *base, gb_active_set *active, long *carried) {
    const long n = rows->n, m = rows->n_speeds;
    const long integers = (5 * n + 3 * m + 8 + rows->n_reduced + rows->n_factors + 1) / 2;
    const long size = gb_delassus_size(rows->n, rows->pattern);
    double *at = base;
    active->count = gb_active_take(&at, 1);
    active->index = gb_active_take(&at, n);
    active->redundant = gb_active_take(&at, n);
    active->n_rows = (int *)gb_active_take(&at, integers);
    active->n_roots = active->n_rows + 1;
    active->n_held = active->n_roots + 1;
    active->has_answer = active->n_held + 1;
    active->n_shared = active->has_answer + 1;
    active->shared = active->n_shared + 1;
    active->root = active->shared + n;
    active->tied = active->root + m;
    active->tie_start = active->tied + m;
    active->of = active->tie_start + m + 1;
    active->pivot = active->of + n;
    active->start = active->pivot + n;
    active->factor_start = active->start + n + 1;
    active->column = active->factor_start + n + 1;
    active->factor_row = active->column + rows->n_reduced;
    active->value = gb_active_take(&at, rows->n_reduced);
    active->factor = gb_active_take(&at, rows->n_factors);
    active->scale = gb_active_take(&at, n);
    active->tie_gain = gb_active_take(&at, rows->n_speeds);
    active->inverse_mass = gb_active_take(&at, rows->n_speeds);
    active->answer = gb_active_take(&at, m <= GB_PAD ? m * GB_PAD : 0);
    active->inverse = gb_active_take(&at, size);
    active->share = gb_active_take(&at, rows->shares ? n * n : 0);
    *carried = at - base;
    active->room = gb_active_take(&at, size);
    active->matrix = gb_active_take(&at, rows->pattern ? 0 : size);
    return at - base;
}

/* What lies behind the saved part may be written to, so `base` is not const behind the scenes. */
GB_INLINE gb_active_set gb_active_at(const gb_constraint_rows *rows, const double *base) {
    gb_active_set active;
    long carried;
    gb_active_lay(rows, (double *)base, &active, &carried);
    return active;
}

static inline double gb_row_dot(const gb_constraint_rows *rows, const double *value, int i, const double *x) {
    double sum = 0.0;
    for (int j = rows->start[i]; j < rows->start[i + 1]; j++) {
        sum += value[j] * x[rows->speed[rows->column[j]]];
    }
    return sum;
}

static inline void gb_row_add(const gb_constraint_rows *rows, const double *value, int i, double force, double *x) {
    for (int j = rows->start[i]; j < rows->start[i + 1]; j++) {
        x[rows->speed[rows->column[j]]] += value[j] * force;
    }
}

/* A row being reduced: coefficients by column, the columns that it has come to, which row has a column as its pivot;
 * lightness by column (NULL: all alike). */
typedef struct gb_reduction {
    double *own;
    int *touched, *is_touched, *row_of, n_touched;
    const double *light;
} gb_reduction;

/* Part of the largest coefficient that a lighter speed must have to be the pivot. */
static const double GB_PIVOT_PART = 0.01;

static inline void gb_reduction_add(gb_reduction *work, int column, double part) {
    if (!work->is_touched[column]) {
        work->is_touched[column] = 1;
        work->touched[work->n_touched++] = column;
        work->own[column] = 0.0;
    }
    work->own[column] += part;
}

/* The first of the rows before whose pivot the row has; -1: none. */
static inline int gb_reduction_next(const gb_reduction *work) {
    int next = -1;
    for (int k = 0; k < work->n_touched; k++) {
        const int c = work->touched[k], q = work->row_of[c];
        next = q >= 0 && work->own[c] != 0.0 && (next < 0 || q < next) ? q : next;
    }
    return next;
}

/* The largest coefficient of the row, and its pivot: what moves most by a force along it, of equal ones the first
 * column. The accelerations of light bodies cancel; what follows from heavier ones passes no rounding on. */
static inline double gb_reduction_pivot(const gb_reduction *work, int *pivot) {
    double left = 0.0, most = 0.0;
    for (int k = 0; k < work->n_touched; k++) {
        left = fmax(left, fabs(work->own[work->touched[k]]));
    }
    for (int k = 0; k < work->n_touched; k++) {
        const int c = work->touched[k];
        const double size = fabs(work->own[c]), moves = work->light ? size * size * work->light[c] : size;
        if (size > GB_PIVOT_PART * left && (moves > most || (moves == most && most > 0.0 && c < *pivot))) {
            most = moves;
            *pivot = c;
        }
    }
    return left;
}

/* The next row of the active set takes row i of the constraints and is reduced by the rows before, if more is left of
 * it than `least` of its largest coefficient: else it is redundant. */
static inline void gb_active_reduce(const gb_constraint_rows *rows, const double *value, int i, double least,
                                    gb_reduction *work, gb_active_set *a) {
    double size = 0.0;
    int pivot = 0, r = *a->n_rows, at = a->start[r], factors = a->factor_start[r];
    work->n_touched = 0;
    for (int j = rows->start[i]; j < rows->start[i + 1]; j++) {
        gb_reduction_add(work, rows->column[j], value[j]);
        size = fmax(size, fabs(value[j]));
    }
    for (int q = gb_reduction_next(work); q >= 0; q = gb_reduction_next(work)) {
        const double factor = work->own[a->pivot[q]];
        work->own[a->pivot[q]] = 0.0;
        for (int e = a->start[q]; e < a->start[q + 1]; e++) {
            gb_reduction_add(work, a->column[e], -factor * a->value[e]);
        }
        if (rows->n_factors > 0) {
            a->factor_row[factors] = q;
            a->factor[factors++] = factor;
        }
    }
    const int independent = gb_reduction_pivot(work, &pivot) > least * size;
    const double scale = independent ? 1.0 / work->own[pivot] : 0.0;
    for (int k = 0; k < work->n_touched; k++) {
        const int c = work->touched[k];
        work->is_touched[c] = 0;
        if (independent && c != pivot && work->own[c] != 0.0) {
            a->column[at] = c;
            a->value[at++] = work->own[c] * scale;
        }
    }
    if (independent) {
        work->row_of[pivot] = r;
        a->of[r] = i;
        a->pivot[r] = pivot;
        a->scale[r] = scale;
        a->start[r + 1] = at;
        a->factor_start[r + 1] = factors;
        *a->n_rows = r + 1;
    }
}

/* Reduces the rows in `from` (of which there are `count`) in that order and keeps those that are independent. light: by
 * speed, how little inertia it has, in parts of any other one's (NULL: all alike). */
static inline void gb_active_rows(const gb_constraint_rows *rows, const double *value, const double *light, int count,
                                  const int *from, double least, gb_active_set *a) {
    const int m = rows->n_columns;
    double own[m + 1], light_of[m + 1];
    int touched[m + 1], is_touched[m + 1], row_of[m + 1];
    gb_reduction work = {own, touched, is_touched, row_of, 0, light ? light_of : NULL};
    for (int c = 0; c < m; c++) {
        is_touched[c] = 0;
        row_of[c] = -1;
        light_of[c] = light ? light[rows->speed[c]] : 1.0;
    }
    *a->n_rows = a->start[0] = a->factor_start[0] = 0;
    for (int i = 0; i < count; i++) {
        gb_active_reduce(rows, value, from[i], least, &work, a);
    }
}

#endif
