#include "gb_active_choice.h"

/* Marks constraints whose force the motion does not tell since the active constraint d follows from them. */
static void gb_active_mark(const gb_constraint_rows *rows, const gb_delassus *W, int d, gb_active_set *a) {
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

void gb_active_choose(const gb_constraint_rows *rows, const double *value, const double *light, const int *is_active,
                      const double *matrix, gb_active_set *a) {
    const int n = rows->n;
    const gb_delassus W = {n, rows->pattern, matrix};
    int from[n + 1], is_own[n + 1], count = 0;
    from[0] = 0;
    for (int i = 0; i < n; i++) {
        a->redundant[i] = 0.0;
        is_own[i] = 0;
        if (is_active[i]) {
            from[count++] = i;
        }
    }
    gb_active_rows(rows, value, light, count, from, 1e-9, a);
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
    if (rows->shares) {
        gb_active_invert(rows, matrix, a);
    }
}

void gb_active_restore(const gb_constraint_rows *rows, const double *value, const double *light, const double *matrix,
                       gb_active_set *a) {
    gb_active_renew(rows, value, light, matrix, a);
}

/* Products with this factor are exact. */
static int gb_is_power_of_two(double x) {
    int exponent;
    return fabs(frexp(x, &exponent)) == 0.5;
}

/* The speed that each speed follows in the end (-1: it is at rest), and with which gain; 0: one of them follows from
 * several, or not by one product to the last bit. */
static int gb_active_follow(const gb_constraint_rows *rows, const gb_active_set *a, int *root, double *gain) {
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
static void gb_active_answer(const gb_constraint_rows *rows, const int *root, const double *gain, gb_active_set *a) {
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

void gb_active_tie(const gb_constraint_rows *rows, const double *mass, const double *inverse_mass, gb_active_set *a) {
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
