/* The active set of switched constraints G v + g(t) = 0 (gb_constraint_rows.h):
 *     slip acceleration = free acceleration + W lambda,   W = G M^-1 G' (gb_delassus.h; lambda: constraint forces),
 * lambda = -W_aa^-1 (free slip accelerations) for its independent rows; the pivots follow from the other speeds
 * exactly, not by integration. Redundant rows have forces too: those of rows that give a little, all alike. With R
 * their rows out of the independent ones,  lambda = R y,  W R y = -(free slip accelerations), of minimum norm where W
 * is symmetric; with lossy gears, which lose by them, the motion hangs on it. Where each of them follows from one speed
 * alone and M is diagonal the active set is like rigid ties: torques pass from the pivots to the speeds that they
 * follow, inertias have done so before. Assumed: the factors of lossy gears (columns of W less `skew` times that of the
 * partner) leave W_aa regular. Source: Pfeiffer and Glocker, Multibody dynamics with unilateral contacts, 1996.
 * Knows nothing of friction laws or of time. */
#ifndef GB_ACTIVE_SET_H
#define GB_ACTIVE_SET_H

#include "gb_constraint_rows.h"

/* A matrix of k x k numbers in the room, inverted. */
static inline void gb_active_invert_room(int k, gb_active_set *a) {
    for (int i = 0; i < k * k; i++) {
        a->inverse[i] = i % (k + 1) == 0 ? 1.0 : 0.0;
    }
    gb_gauss_jordan(k, k, a->room, k, a->inverse);
}

/* The rows that follow from others with their shares, R = W_redundant W_independent^-1; W R inverted in its place. */
static inline void gb_active_share(const gb_constraint_rows *rows, const double *matrix, gb_active_set *a) {
    const int n = rows->n, k = (int)*a->count;
    int is_own[n + 1], count = 0;
    memset(is_own, 0, sizeof is_own);
    for (int r = 0; r < k; r++) {
        is_own[(int)a->index[r]] = 1;
    }
    for (int i = 0; i < n; i++) {
        if (a->redundant[i] != 0.0 && !is_own[i]) {
            a->shared[count++] = i;
        }
    }
    *a->n_shared = count;
    for (int d = 0; d < count; d++) {
        for (int j = 0; j < k; j++) {
            double sum = 0.0;
            for (int i = 0; i < k; i++) {
                sum += matrix[(long)a->shared[d] * n + (long)a->index[i]] * a->inverse[(long)i * k + j];
            }
            a->share[(long)d * n + j] = sum;
        }
    }
    for (int i = 0; i < k && count > 0; i++) {
        for (int j = 0; j < k; j++) {
            double sum = matrix[(long)a->index[i] * n + (long)a->index[j]];
            for (int d = 0; d < count; d++) {
                sum += matrix[(long)a->index[i] * n + a->shared[d]] * a->share[(long)d * n + j];
            }
            a->room[(long)i * k + j] = sum;
        }
    }
    if (count > 0) {
        gb_active_invert_room(k, a);
    }
}

/* W of the independent active rows, factored; all numbers: inverted. */
static inline void gb_active_invert(const gb_constraint_rows *rows, const double *matrix, gb_active_set *a) {
    const int n = rows->n, k = (int)*a->count;
    if (rows->pattern) {
        const gb_delassus W = {n, rows->pattern, matrix};
        int in[n + 1];
        memset(in, 0, sizeof in);
        for (int r = 0; r < k; r++) {
            in[(int)a->index[r]] = 1;
        }
        gb_delassus_factor(&W, in, NULL, a->inverse);
        return;
    }
    for (int i = 0; i < k; i++) {
        for (int j = 0; j < k; j++) {
            a->room[(long)i * k + j] = matrix[(long)a->index[i] * n + (long)a->index[j]];
        }
    }
    gb_active_invert_room(k, a);
    *a->n_shared = 0;
    if (rows->shares) {
        gb_active_share(rows, matrix, a);
    }
}

/* x = W_aa^-1 b for the independent active rows, by constraint, those that follow from them with their shares; 0 for
 * all others. */
static inline void gb_active_solve(const gb_constraint_rows *rows, const gb_active_set *a, const double *b, double *x) {
    const int n = rows->n, k = (int)*a->count;
    for (int i = 0; i < n; i++) {
        x[i] = 0.0;
    }
    for (int i = 0; i < k; i++) {
        double sum = rows->pattern ? b[(int)a->index[i]] : 0.0;
        for (int j = 0; j < k && !rows->pattern; j++) {
            sum += a->inverse[(long)i * k + j] * b[(int)a->index[j]];
        }
        x[(int)a->index[i]] = sum;
    }
    if (rows->pattern) {
        gb_delassus_solve(n, rows->pattern, a->inverse, x);
        return;
    }
    for (int d = 0; d < *a->n_shared; d++) {
        for (int j = 0; j < k; j++) {
            x[a->shared[d]] += a->share[(long)d * n + j] * x[(int)a->index[j]];
        }
    }
}

/* The independent constraints of an active set, into kept[]; returns how many. */
static inline int gb_active_indices(const gb_active_set *a, int *kept) {
    const int count = (int)*a->count;
    for (int r = 0; r < count; r++) {
        kept[r] = (int)a->index[r];
    }
    return count;
}

/* What follows from an active set that is known: after a state was restored, or at another position where the values of
 * rows change with it. */
static inline void gb_active_renew(const gb_constraint_rows *rows, const double *value, const double *light,
                                   const double *matrix, gb_active_set *a) {
    int kept[rows->n + 1];
    gb_active_rows(rows, value, light, gb_active_indices(a, kept), kept, 0.0, a);
    gb_active_invert(rows, matrix, a);
}

/* Velocity projection (of accelerations too): the pivots follow from the other speeds, so that the slips of x vanish
 * exactly. bias: slips besides (NULL: none). */
static inline void gb_active_project(const gb_constraint_rows *rows, const gb_active_set *a, const double *bias,
                                     double *x) {
    const int k = *a->n_rows;
    double own_bias[bias ? k + 1 : 1];
    for (int r = 0; r < k && bias; r++) {
        own_bias[r] = bias[a->of[r]];
        for (int e = a->factor_start[r]; e < a->factor_start[r + 1]; e++) {
            own_bias[r] -= a->factor[e] * own_bias[a->factor_row[e]];
        }
        own_bias[r] *= a->scale[r];
    }
    for (int r = k - 1; r >= 0; r--) {
        double sum = 0.0;
        for (int e = a->start[r]; e < a->start[r + 1]; e++) {
            sum += a->value[e] * x[rows->speed[a->column[e]]];
        }
        x[rows->speed[a->pivot[r]]] = 0.0 - (bias ? sum + own_bias[r] : sum);
    }
}

/* Accelerations from torques on a few speeds. */
GB_INLINE void gb_active_respond(const gb_constraint_rows *rows, const gb_active_set *a, double *x) {
    gb_block sum = {0.0};
    for (int j = 0; j < rows->n_speeds; j++) {
        sum += *(const gb_block *)(const void *)(a->answer + j * GB_PAD) * x[j];
    }
    for (int i = 0; i < rows->n_speeds; i++) {
        x[i] = sum[i];
    }
}

/* Accelerations from torques for an active set that is like ties. */
GB_INLINE void gb_active_accelerate(const gb_constraint_rows *rows, const gb_active_set *a, double *x) {
    const int roots = *a->n_roots, held = a->tie_start[roots];
    for (int q = 0; q < roots; q++) {
        double sum = x[a->root[q]];
        for (int e = a->tie_start[q]; e < a->tie_start[q + 1]; e++) {
            sum += a->tie_gain[e] * x[a->tied[e]];
        }
        x[a->root[q]] = sum;
    }
    for (int i = 0; i < rows->n_speeds; i++) {
        x[i] *= a->inverse_mass[i];
    }
    for (int q = 0; q < roots; q++) {
        const double root = x[a->root[q]];
        for (int e = a->tie_start[q]; e < a->tie_start[q + 1]; e++) {
            x[a->tied[e]] = 0.0 + a->tie_gain[e] * root;
        }
    }
    for (int e = held; e < held + *a->n_held; e++) {
        x[a->tied[e]] = 0.0;
    }
}

#endif
