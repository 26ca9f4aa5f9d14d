/* Switched velocity constraints:  G v + g(t) = 0  for the rows of the active set.
 *     slip acceleration = free acceleration + W lambda,   W = G M^-1 G' (Delassus matrix; lambda: constraint forces).
 * Active rows are reduced to echelon form, each solved for one speed (the largest coefficient that is left); a row
 * that follows from those before is redundant. lambda = -W_aa^-1 (free slip accelerations) for the independent ones;
 * redundant ones by the minimum-norm split within their bounds. The speeds solved for follow from the others exactly,
 * not by integration.
 * Assumed: the factors of lossy gears (columns of W less `skew` times that of the partner) leave W_aa regular.
 * Sources: echelon form by Gauss-Jordan elimination; forces as Pfeiffer and Glocker 1996.
 * Knows nothing of friction laws or of time.
 *
 * The active set lies behind the modes, as doubles: count, indices, redundancy, pivots, W_aa^-1, the steps of the
 * reduction, the reduced rows. */
#ifndef GB_CONSTRAINT_ROWS_H
#define GB_CONSTRAINT_ROWS_H

#include "gb_loss.h"

/* Rows: entries [start[i], start[i + 1]) lie in the columns column[]; column c is speed[c]. */
typedef struct gb_constraint_rows {
    int n, n_columns;
    const int *start, *column, *speed;
} gb_constraint_rows;

/* Offsets in an active set of n constraints over m columns. */
enum { GB_ACTIVE_COUNT = 0, GB_ACTIVE_INDEX = 1 };
static inline int gb_active_redundant(int n) {
    return 1 + n;
}
static inline int gb_active_pivot(int n) {
    return 1 + 2 * n;
}
static inline int gb_active_inverse(int n) {
    return 1 + 3 * n;
}
static inline int gb_active_steps(int n) {
    return 1 + 3 * n + n * n;
}
static inline int gb_active_reduced(int n) {
    return 1 + 3 * n + 2 * n * n;
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

/* Row r of the active set takes row i of the constraints and is reduced by the rows before; 0: it is redundant. */
static inline int gb_active_take(const gb_constraint_rows *rows, const double *value, int i, int r, double *active) {
    const int n = rows->n, m = rows->n_columns;
    double *steps = active + gb_active_steps(n), *reduced = active + gb_active_reduced(n), size = 0.0, left = 0.0;
    double *own = reduced + r * m, *own_steps = steps + r * n;
    memset(own, 0, sizeof(double) * (size_t)m);
    memset(own_steps, 0, sizeof(double) * (size_t)n);
    for (int j = rows->start[i]; j < rows->start[i + 1]; j++) {
        own[rows->column[j]] += value[j];
        size = fmax(size, fabs(value[j]));
    }
    own_steps[r] = 1.0;
    for (int q = 0; q < r; q++) {
        const double factor = own[(int)active[gb_active_pivot(n) + q]];
        for (int c = 0; c < m && factor != 0.0; c++) {
            own[c] -= factor * reduced[q * m + c];
        }
        for (int c = 0; c <= r && factor != 0.0; c++) {
            own_steps[c] -= factor * steps[q * n + c];
        }
    }
    int pivot = 0;
    for (int c = 0; c < m; c++) {
        if (fabs(own[c]) > left) {
            left = fabs(own[c]);
            pivot = c;
        }
    }
    if (!(left > 1e-9 * size)) {
        return 0;
    }
    const double scale = 1.0 / own[pivot];
    for (int c = 0; c < m; c++) {
        own[c] = c == pivot ? 1.0 : own[c] * scale;
    }
    for (int c = 0; c <= r; c++) {
        own_steps[c] *= scale;
    }
    active[gb_active_pivot(n) + r] = pivot;
    for (int q = 0; q < r; q++) {
        const double factor = reduced[q * m + pivot];
        for (int c = 0; c < m && factor != 0.0; c++) {
            reduced[q * m + c] = c == pivot ? 0.0 : reduced[q * m + c] - factor * own[c];
        }
        for (int c = 0; c <= r && factor != 0.0; c++) {
            steps[q * n + c] -= factor * own_steps[c];
        }
    }
    return 1;
}

/* The Delassus matrix of the independent active rows, inverted. */
static inline void gb_active_invert(int n, const double *matrix, double *active) {
    const int k = (int)active[GB_ACTIVE_COUNT];
    const double *index = active + GB_ACTIVE_INDEX;
    double *inverse = active + gb_active_inverse(n), A[k * k + 1];
    for (int i = 0; i < k; i++) {
        for (int j = 0; j < k; j++) {
            A[i * k + j] = matrix[(int)index[i] * n + (int)index[j]];
            inverse[i * k + j] = i == j ? 1.0 : 0.0;
        }
    }
    gb_gauss_jordan(k, k, A, k, inverse);
}

/* The active set: which of the constraints with is_active[i] are independent, in reduced form; `redundant` marks those
 * whose force the motion does not tell. */
static inline void gb_active_choose(const gb_constraint_rows *rows, const double *value, const int *is_active,
                                    const double *matrix, double *active) {
    const int n = rows->n;
    double *redundant = active + gb_active_redundant(n);
    int k = 0;
    for (int i = 0; i < n; i++) {
        redundant[i] = 0.0;
        if (is_active[i] && gb_active_take(rows, value, i, k, active)) {
            active[GB_ACTIVE_INDEX + k++] = i;
        }
    }
    active[GB_ACTIVE_COUNT] = k;
    gb_active_invert(n, matrix, active);
    for (int d = 0; d < n; d++) {
        int independent = 0;
        for (int j = 0; j < k; j++) {
            independent = independent || (int)active[GB_ACTIVE_INDEX + j] == d;
        }
        if (!is_active[d] || independent) {
            continue;
        }
        redundant[d] = 1.0;
        for (int i = 0; i < k; i++) {
            double share = 0.0, size = 0.0;
            for (int j = 0; j < k; j++) {
                const double part =
                    active[gb_active_inverse(n) + i * k + j] * matrix[(int)active[GB_ACTIVE_INDEX + j] * n + d];
                share += part;
                size += fabs(part);
            }
            redundant[(int)active[GB_ACTIVE_INDEX + i]] =
                fabs(share) > 1e-9 * size ? 1.0 : redundant[(int)active[GB_ACTIVE_INDEX + i]];
        }
    }
}

/* The same rows at another position, where their values change with it. */
static inline void gb_active_renew(const gb_constraint_rows *rows, const double *value, const double *matrix,
                                   double *active) {
    const int k = (int)active[GB_ACTIVE_COUNT];
    for (int r = 0; r < k; r++) {
        gb_active_take(rows, value, (int)active[GB_ACTIVE_INDEX + r], r, active);
    }
    gb_active_invert(rows->n, matrix, active);
}

/* Constraint forces of the independent active rows, from the free slip accelerations; 0 for all others. */
static inline void gb_active_forces(int n, const double *active, const double *bare, double *force) {
    const int k = (int)active[GB_ACTIVE_COUNT];
    for (int i = 0; i < n; i++) {
        force[i] = 0.0;
    }
    for (int i = 0; i < k; i++) {
        double sum = 0.0;
        for (int j = 0; j < k; j++) {
            sum -= active[gb_active_inverse(n) + i * k + j] * bare[(int)active[GB_ACTIVE_INDEX + j]];
        }
        force[(int)active[GB_ACTIVE_INDEX + i]] = sum;
    }
}

/* Velocity projection (of accelerations too): the pivots follow from the other speeds, so that the slips of x vanish
 * exactly. bias: slips besides (NULL: none). */
static inline void gb_active_project(const gb_constraint_rows *rows, const double *active, const double *bias,
                                     double *x) {
    const int n = rows->n, m = rows->n_columns, k = (int)active[GB_ACTIVE_COUNT];
    for (int r = 0; r < k; r++) {
        const double *own = active + gb_active_reduced(n) + r * m, *steps = active + gb_active_steps(n) + r * n;
        const int pivot = (int)active[gb_active_pivot(n) + r];
        double sum = 0.0;
        for (int c = 0; c < m; c++) {
            sum += c == pivot || own[c] == 0.0 ? 0.0 : own[c] * x[rows->speed[c]];
        }
        for (int j = 0; j < k && bias; j++) {
            sum += steps[j] * bias[(int)active[GB_ACTIVE_INDEX + j]];
        }
        x[rows->speed[pivot]] = 0.0 - sum;
    }
}

/* Columns of lossy gears in the Delassus matrix: of their force the partner takes the part skew[j] away again. */
static inline void gb_delassus_skew(int n, const int *partner, const double *skew, double *matrix) {
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n && skew[j] != 0.0; i++) {
            matrix[i * n + j] -= skew[j] * matrix[i * n + partner[j]];
        }
    }
}

/* A split of the load of redundant active constraints, numbered by index[]: force x of each within its bounds, those of
 * a lossy gear along its sides forward and backward, two numbers each. */
static inline void gb_split_once(int n, int count, const int *index, const int *is_own, const double *A,
                                 const double *b, const double *lower, const double *upper, const int *tie_of,
                                 const double *losses, const int *sides, double *x, int *on) {
    double lo[count + 1], hi[count + 1], lo_slope[count + 1], hi_slope[count + 1];
    int position[n + 1];
    for (int p = 0; p < count; p++) {
        position[index[p]] = p;
    }
    for (int p = 0; p < count; p++) {
        const int i = index[p], own = is_own[p];
        on[p] = -1;
        lo[p] = own ? -HUGE_VAL : lower[i];
        hi[p] = own ? HUGE_VAL : fmax(lower[i], upper[i]);
        if (tie_of && tie_of[i] >= 0 && !own) {
            const gb_loss_line forward = gb_loss_on_side(losses + 5 * (long)i, sides[2 * p]),
                               backward = gb_loss_on_side(losses + 5 * (long)i, sides[2 * p + 1]);
            on[p] = position[tie_of[i]];
            lo[p] = -forward.fixed;
            lo_slope[p] = -forward.slope;
            hi[p] = backward.fixed;
            hi_slope[p] = -backward.slope;
        }
    }
    const gb_coupled_bounds coupled = {on, lo_slope, hi_slope};
    gb_lcp_solve(count, A, b, lo, hi, tie_of ? &coupled : NULL, x);
}

/* The same, with the sides of the forces that come out: Newton steps, all lossy gears at once, later one alone. */
static inline void gb_split_by_sides(int n, int count, const int *index, const int *is_own, const double *A,
                                     const double *b, const double *lower, const double *upper, const int *tie_of,
                                     const double *losses, const double *force, double *x) {
    int on[count + 1], sides[2 * count + 1], wrong = 1;
    for (int p = 0; p < count && tie_of; p++) {
        const double *of = losses + 5 * (long)index[p], tie = tie_of[index[p]] >= 0 ? force[tie_of[index[p]]] : 0.0;
        sides[2 * p] = gb_loss_side(of, tie);
        sides[2 * p + 1] = gb_loss_side(of, -tie);
    }
    for (int round = 0; wrong && round < 4 + count; round++) {
        double largest = 0.0;
        gb_split_once(n, count, index, is_own, A, b, lower, upper, tie_of, losses, sides, x, on);
        for (int p = 0; p < count; p++) {
            largest = fmax(largest, fabs(x[p]));
        }
        wrong = 0;
        for (int p = 0; p < count && (round < 4 || !wrong); p++) {
            const double *of = losses + 5 * (long)index[p];
            if (on[p] >= 0 && !gb_loss_agrees(of, sides[2 * p], sides[2 * p + 1], x[on[p]], x[p], 1e-12 * largest)) {
                sides[2 * p] = gb_loss_side(of, x[on[p]]);
                sides[2 * p + 1] = gb_loss_side(of, -x[on[p]]);
                wrong = 1;
            }
        }
    }
}

/* Minimum-norm split: by how much the force of each active constraint exceeds its bounds, < 0 inside; -1 for all
 * others. Redundant constraints share by minimum norm within their bounds, and exceed them together once there is no
 * such split. tie_of: of the loss of a lossy gear its tie, -1 for all others (NULL: there is none); its losses are five
 * numbers further each. */
static inline void gb_split_forces(int n, const double *active, const double *matrix, const int *is_active,
                                   const double *lower, const double *upper, const int *tie_of, const double *losses,
                                   double *force, double *violation) {
    int index[n + 1], count = 0, redundant = 0;
    for (int i = 0; i < n; i++) {
        if (is_active[i]) {
            index[count++] = i;
            redundant = redundant || active[gb_active_redundant(n) + i] != 0.0;
        }
    }
    if (redundant) {
        double A[count * count + 1], b[count + 1], x[count + 1], worst = 0.0, size = 0.0;
        int is_own[count + 1];
        for (int p = 0; p < count; p++) {
            const int i = index[p];
            is_own[p] = active[gb_active_redundant(n) + i] == 0.0;
            b[p] = 0.0;
            for (int q = 0; q < count; q++) {
                A[p * count + q] = matrix[i * n + index[q]];
                b[p] -= A[p * count + q] * force[index[q]];
            }
        }
        gb_split_by_sides(n, count, index, is_own, A, b, lower, upper, tie_of, losses, force, x);
        for (int p = 0; p < count; p++) {
            double left = b[p], terms = fabs(b[p]);
            for (int q = 0; q < count; q++) {
                left += A[p * count + q] * x[q];
                terms += fabs(A[p * count + q] * x[q]);
            }
            worst = fmax(worst, active[gb_active_redundant(n) + index[p]] != 0.0 ? fabs(left) : 0.0);
            size = fmax(size, terms);
        }
        for (int p = 0; p < count; p++) {
            force[index[p]] = x[p];
            violation[index[p]] =
                worst - (tie_of ? 1e-8 : 1e-11) * size - DBL_MIN; /* coupled bounds keep what is lifted */
        }
    }
    for (int i = 0; i < n; i++) {
        if (!is_active[i]) {
            violation[i] = -1.0;
        } else if (active[gb_active_redundant(n) + i] == 0.0) {
            const int lossy = tie_of && tie_of[i] >= 0;
            const double over = lossy ? gb_loss_excess(losses + 5 * i, force[tie_of[i]], force[i])
                                      : fmax(force[i] - upper[i], lower[i] - force[i]);
            violation[i] = over > -HUGE_VAL ? over : -1.0;
        }
    }
}

#endif
