/* The active set of switched constraints G v + g(t) = 0 (gb_constraint_rows.h):
 *     slip acceleration = free acceleration + W lambda,   W = G M^-1 G' (gb_delassus.h; lambda: constraint forces),
 * lambda = -W_aa^-1 (free slip accelerations) for its independent rows; the pivots follow from the other speeds
 * exactly, not by integration. Where each of them follows from one speed alone and M is diagonal the active set is like
 * rigid ties: torques pass from the pivots to the speeds that they follow, inertias have done so before. Assumed: the
 * factors of lossy gears (columns of W less `skew` times that of the partner) leave W_aa regular. Source: Pfeiffer and
 * Glocker, Multibody dynamics with unilateral contacts, 1996. Knows nothing of friction laws or of time. */
#ifndef GB_ACTIVE_SET_H
#define GB_ACTIVE_SET_H

#include "gb_constraint_rows.h"

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
        gb_delassus_factor(&W, in, 0.0, a->inverse);
        return;
    }
    for (int i = 0; i < k; i++) {
        for (int j = 0; j < k; j++) {
            a->room[(long)i * k + j] = matrix[(long)a->index[i] * n + (long)a->index[j]];
            a->inverse[(long)i * k + j] = i == j ? 1.0 : 0.0;
        }
    }
    gb_gauss_jordan(k, k, a->room, k, a->inverse);
}

/* x = W_aa^-1 b for the independent active rows, by constraint; 0 for all others. */
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
    }
}

/* Marks constraints whose force the motion does not tell since the active constraint d follows from them. */
static inline void gb_active_mark(const gb_constraint_rows *rows, const gb_delassus *W, int d, gb_active_set *a) {
    const int n = rows->n;
    int column[n + 1];
    double value[n + 1], b[n + 1], share[n + 1], most = 0.0;
    memset(b, 0, sizeof b);
    for (int k = gb_delassus_row(W, d, column, value) - 1; k >= 0; k--) {
        b[column[k]] = value[k];
    }
    gb_active_solve(rows, a, b, share);
    for (int i = 0; i < n; i++) { /* in the size of their forces, whatever the units of the rows */
        share[i] = fabs(share[i]) * sqrt(fabs(gb_delassus_diagonal(W, i)));
        most = fmax(most, share[i]);
    }
    for (int i = 0; i < n; i++) {
        a->redundant[i] = i == d || share[i] > 1e-9 * most ? 1.0 : a->redundant[i];
    }
}

/* The active set: which of the constraints with is_active[i] are independent, with its factors; `redundant` marks those
 * whose force the motion does not tell. */
static inline void gb_active_choose(const gb_constraint_rows *rows, const double *value, const int *is_active,
                                    const double *matrix, gb_active_set *a) {
    const int n = rows->n;
    const gb_delassus W = {n, rows->pattern, matrix};
    int from[n + 1], is_own[n + 1], count = 0;
    for (int i = 0; i < n; i++) {
        a->redundant[i] = 0.0;
        is_own[i] = 0;
        if (is_active[i]) {
            from[count++] = i;
        }
    }
    gb_active_rows(rows, value, count, from, 1e-9, a);
    *a->count = *a->n_rows;
    for (int r = 0; r < *a->n_rows; r++) {
        a->index[r] = a->of[r];
        is_own[a->of[r]] = 1;
    }
    gb_active_invert(rows, matrix, a);
    for (int d = 0; d < n; d++) {
        if (is_active[d] && !is_own[d]) {
            gb_active_mark(rows, &W, d, a);
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
static inline void gb_active_renew(const gb_constraint_rows *rows, const double *value, const double *matrix,
                                   gb_active_set *a) {
    int kept[rows->n + 1];
    gb_active_rows(rows, value, gb_active_indices(a, kept), kept, 0.0, a);
    gb_active_invert(rows, matrix, a);
}

/* Products with this factor are exact. */
static inline int gb_is_power_of_two(double x) {
    int exponent;
    return fabs(frexp(x, &exponent)) == 0.5;
}

/* The speed that each speed follows in the end (-1: it is at rest), and with which gain; 0: one of them follows from
 * several, or not by one product to the last bit. */
static inline int gb_active_follow(const gb_constraint_rows *rows, const gb_active_set *a, int *root, double *gain) {
    for (int i = 0; i < rows->n_speeds; i++) {
        root[i] = i;
        gain[i] = 1.0;
    }
    for (int r = *a->n_rows - 1; r >= 0; r--) {
        const int i = rows->speed[a->pivot[r]], e = a->start[r], count = a->start[r + 1] - e;
        const int next = count > 0 ? rows->speed[a->column[e]] : 0;
        if (count > 1 || (count > 0 && !gb_is_power_of_two(a->value[e]) && !gb_is_power_of_two(gain[next]))) {
            return 0;
        }
        root[i] = count > 0 ? root[next] : -1;
        gain[i] = count > 0 ? -a->value[e] * gain[next] : 0.0;
    }
    return 1;
}

/* Accelerations per torque on each of a few speeds, where all gains are powers of two, so that slips are zero to the
 * last bit. */
static inline void gb_active_answer(const gb_constraint_rows *rows, const int *root, const double *gain,
                                    gb_active_set *a) {
    const int m = rows->n_speeds;
    *a->has_answer = m <= GB_PAD;
    for (int i = 0; i < m; i++) {
        *a->has_answer = *a->has_answer && (root[i] < 0 || gb_is_power_of_two(gain[i]));
    }
    for (int j = 0; j < m && *a->has_answer; j++) {
        for (int i = 0; i < GB_PAD; i++) {
            const int together = i < m && root[j] >= 0 && root[i] == root[j];
            a->answer[j * GB_PAD + i] = together ? gain[i] * gain[j] * a->inverse_mass[root[j]] : 0.0;
        }
    }
}

/* The active set as ties, where it is like them; with a diagonal mass matrix. */
static inline void gb_active_tie(const gb_constraint_rows *rows, const double *mass, const double *inverse_mass,
                                 gb_active_set *a) {
    const int m = rows->n_speeds;
    double gain[m + 1], sum[m + 1];
    int root[m + 1], count[m + 1], at = 0;
    memset(count, 0, sizeof count);
    *a->n_roots = *a->n_held = *a->has_answer = 0;
    if (!gb_active_follow(rows, a, root, gain)) {
        *a->n_roots = -1;
        return;
    }
    for (int i = 0; i < m; i++) {
        sum[i] = mass[i];
        a->inverse_mass[i] = inverse_mass[i];
        count[root[i] >= 0 && root[i] != i ? root[i] : m] += root[i] != i;
    }
    for (int i = 0; i < m; i++) { /* count becomes where the next one goes */
        if (count[i] > 0) {
            a->root[*a->n_roots] = i;
            a->tie_start[(*a->n_roots)++] = at;
            at += count[i];
            count[i] = a->tie_start[*a->n_roots - 1];
        }
    }
    a->tie_start[*a->n_roots] = at;
    *a->n_held = count[m];
    count[m] = at;
    for (int i = 0; i < m; i++) {
        if (root[i] != i) {
            const int place = count[root[i] >= 0 ? root[i] : m]++;
            a->tied[place] = i;
            a->tie_gain[place] = gain[i];
        }
        if (root[i] >= 0 && root[i] != i) {
            sum[root[i]] += gain[i] * gain[i] * mass[i];
            a->inverse_mass[root[i]] = 1.0 / sum[root[i]];
        }
    }
    gb_active_answer(rows, root, gain, a);
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
static inline __attribute__((always_inline)) void gb_active_respond(const gb_constraint_rows *rows,
                                                                    const gb_active_set *a, double *x) {
    gb_block sum = {0.0};
    for (int j = 0; j < rows->n_speeds; j++) {
        sum += *(const gb_block *)(const void *)(a->answer + j * GB_PAD) * x[j];
    }
    for (int i = 0; i < rows->n_speeds; i++) {
        x[i] = sum[i];
    }
}

/* Accelerations from torques for an active set that is like ties. */
static inline __attribute__((always_inline)) void gb_active_accelerate(const gb_constraint_rows *rows,
                                                                       const gb_active_set *a, double *x) {
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
