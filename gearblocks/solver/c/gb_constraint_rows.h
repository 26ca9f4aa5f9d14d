/* Switched velocity constraints:  G v + g(t) = 0  for the rows of the active set.
 *     slip acceleration = free acceleration + W lambda,   W = G M^-1 G' (Delassus matrix; lambda: constraint forces).
 * Active rows are reduced to echelon form, each solved for one speed (the largest coefficient that is left); a row
 * that says nothing new is redundant. lambda = -W_aa^-1 (free slip accelerations) for the independent ones; redundant
 * ones share by minimum norm within their bounds. The speeds solved for follow from the others exactly, not by
 * integration.
 * Assumed: the factors of lossy gears (columns of W less `skew` times that of the partner) leave W_aa regular.
 * Sources: echelon form by Gauss-Jordan elimination; forces as Pfeiffer and Glocker 1996.
 * Knows nothing of friction laws or of time.
 *
 * The active set lies behind the modes ("memory"), as doubles: count, indices, redundancy, pivots, W_aa^-1, the steps
 * of the reduction, the reduced rows. */
#ifndef GB_CONSTRAINT_ROWS_H
#define GB_CONSTRAINT_ROWS_H

#include "gb_lcp.h"

/* Rows: entries [start[i], start[i + 1]) lie in the columns column[]; column c is speed[c]. */
typedef struct gb_lock_rows {
    int n, n_columns;
    const int *start, *column, *speed;
} gb_lock_rows;

/* Places in the memory of n locks over m columns. */
enum { GB_LOCK_COUNT = 0, GB_LOCK_INDEX = 1 };
static inline int gb_lock_shared(int n) {
    return 1 + n;
}
static inline int gb_lock_pivot(int n) {
    return 1 + 2 * n;
}
static inline int gb_lock_inverse(int n) {
    return 1 + 3 * n;
}
static inline int gb_lock_steps(int n) {
    return 1 + 3 * n + n * n;
}
static inline int gb_lock_reduced(int n) {
    return 1 + 3 * n + 2 * n * n;
}
static inline int gb_lock_size(int n, int m) {
    return 1 + 3 * n + 2 * n * n + n * m;
}

static inline double gb_lock_dot(const gb_lock_rows *rows, const double *value, int i, const double *x) {
    double sum = 0.0;
    for (int j = rows->start[i]; j < rows->start[i + 1]; j++) {
        sum += value[j] * x[rows->speed[rows->column[j]]];
    }
    return sum;
}

static inline void gb_lock_add(const gb_lock_rows *rows, const double *value, int i, double force, double *x) {
    for (int j = rows->start[i]; j < rows->start[i + 1]; j++) {
        x[rows->speed[rows->column[j]]] += value[j] * force;
    }
}

/* Row r of the memory takes row i of the locks and is reduced by the rows before; 0: it says nothing new. */
static inline int gb_lock_take(const gb_lock_rows *rows, const double *value, int i, int r, double *memory) {
    const int n = rows->n, m = rows->n_columns;
    double *steps = memory + gb_lock_steps(n), *reduced = memory + gb_lock_reduced(n), size = 0.0, left = 0.0;
    double *own = reduced + r * m, *own_steps = steps + r * n;
    memset(own, 0, sizeof(double) * (size_t)m);
    memset(own_steps, 0, sizeof(double) * (size_t)n);
    for (int j = rows->start[i]; j < rows->start[i + 1]; j++) {
        own[rows->column[j]] += value[j];
        size = fmax(size, fabs(value[j]));
    }
    own_steps[r] = 1.0;
    for (int q = 0; q < r; q++) {
        const double factor = own[(int)memory[gb_lock_pivot(n) + q]];
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
    memory[gb_lock_pivot(n) + r] = pivot;
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

/* The responses of the rows that hold to their own forces, inverted. */
static inline void gb_lock_invert(int n, const double *matrix, double *memory) {
    const int k = (int)memory[GB_LOCK_COUNT];
    const double *index = memory + GB_LOCK_INDEX;
    double *inverse = memory + gb_lock_inverse(n), A[k * k + 1];
    for (int i = 0; i < k; i++) {
        for (int j = 0; j < k; j++) {
            A[i * k + j] = matrix[(int)index[i] * n + (int)index[j]];
            inverse[i * k + j] = i == j ? 1.0 : 0.0;
        }
    }
    gb_lock_solve(k, k, A, k, inverse);
}

/* Which of the locks with stuck[i] hold, in reduced form; `shared` tells those whose force the motion does not tell. */
static inline void gb_lock_choose(const gb_lock_rows *rows, const double *value, const int *stuck, const double *matrix,
                                  double *memory) {
    const int n = rows->n;
    double *shared = memory + gb_lock_shared(n);
    int k = 0;
    for (int i = 0; i < n; i++) {
        shared[i] = 0.0;
        if (stuck[i] && gb_lock_take(rows, value, i, k, memory)) {
            memory[GB_LOCK_INDEX + k++] = i;
        }
    }
    memory[GB_LOCK_COUNT] = k;
    gb_lock_invert(n, matrix, memory);
    for (int d = 0; d < n; d++) {
        int holds = 0;
        for (int j = 0; j < k; j++) {
            holds = holds || (int)memory[GB_LOCK_INDEX + j] == d;
        }
        if (!stuck[d] || holds) {
            continue;
        }
        shared[d] = 1.0;
        for (int i = 0; i < k; i++) {
            double share = 0.0, size = 0.0;
            for (int j = 0; j < k; j++) {
                const double part =
                    memory[gb_lock_inverse(n) + i * k + j] * matrix[(int)memory[GB_LOCK_INDEX + j] * n + d];
                share += part;
                size += fabs(part);
            }
            shared[(int)memory[GB_LOCK_INDEX + i]] =
                fabs(share) > 1e-9 * size ? 1.0 : shared[(int)memory[GB_LOCK_INDEX + i]];
        }
    }
}

/* The same rows at another position, where their values change with it. */
static inline void gb_lock_renew(const gb_lock_rows *rows, const double *value, const double *matrix, double *memory) {
    const int k = (int)memory[GB_LOCK_COUNT];
    for (int r = 0; r < k; r++) {
        gb_lock_take(rows, value, (int)memory[GB_LOCK_INDEX + r], r, memory);
    }
    gb_lock_invert(rows->n, matrix, memory);
}

/* The forces of the rows that hold, from the slip accelerations that would be without; 0 for all others. */
static inline void gb_lock_forces(int n, const double *memory, const double *bare, double *held) {
    const int k = (int)memory[GB_LOCK_COUNT];
    for (int i = 0; i < n; i++) {
        held[i] = 0.0;
    }
    for (int i = 0; i < k; i++) {
        double sum = 0.0;
        for (int j = 0; j < k; j++) {
            sum -= memory[gb_lock_inverse(n) + i * k + j] * bare[(int)memory[GB_LOCK_INDEX + j]];
        }
        held[(int)memory[GB_LOCK_INDEX + i]] = sum;
    }
}

/* Makes the slips of x vanish exactly: the pivots follow from the other speeds. bias: slips besides (NULL: none). */
static inline void gb_lock_fix(const gb_lock_rows *rows, const double *memory, const double *bias, double *x) {
    const int n = rows->n, m = rows->n_columns, k = (int)memory[GB_LOCK_COUNT];
    for (int r = 0; r < k; r++) {
        const double *own = memory + gb_lock_reduced(n) + r * m, *steps = memory + gb_lock_steps(n) + r * n;
        const int pivot = (int)memory[gb_lock_pivot(n) + r];
        double sum = 0.0;
        for (int c = 0; c < m; c++) {
            sum += c == pivot || own[c] == 0.0 ? 0.0 : own[c] * x[rows->speed[c]];
        }
        for (int j = 0; j < k && bias; j++) {
            sum += steps[j] * bias[(int)memory[GB_LOCK_INDEX + j]];
        }
        x[rows->speed[pivot]] = 0.0 - sum;
    }
}

/* Columns of lossy ties: of their force the partner takes the part skew[j] away again. */
static inline void gb_lock_skew(int n, const int *partner, const double *skew, double *matrix) {
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n && skew[j] != 0.0; i++) {
            matrix[i * n + j] -= skew[j] * matrix[i * n + partner[j]];
        }
    }
}

/* By how much a lossy tie at rest leaves the range between its losses in either direction. limit: share and rest of the
 * force lost driving, then coasting; carried: the force of the tie, held: that of the loss. With the force f = carried
 * + held that leaves the tie, sliding asks for carried = (f + rest)/(1 - share) driving, (f - rest)/(1 - share)
 * coasting; taken over f, the range holds for ties that lock themselves too. */
static inline double gb_lock_loss_excess(const double *limit, double carried, double held) {
    const double f = carried + held, side = f >= 0.0 ? 1.0 : -1.0;
    const double driving = (f + side * limit[1]) / (1.0 - limit[0]),
                 coasting = (f - side * limit[3]) / (1.0 - limit[2]);
    return fmax(side * (carried - driving), side * (coasting - carried));
}

/* By how much the force of each stuck lock exceeds its limits, < 0 inside; -1 for all others. Locks that share a load
 * share it by minimum norm within their limits, and exceed them together once there is no such split. */
static inline void gb_lock_share(int n, const double *memory, const double *matrix, const int *stuck,
                                 const double *lower, const double *upper, double *held, double *excess) {
    int index[n + 1], count = 0, shared = 0;
    for (int i = 0; i < n; i++) {
        if (stuck[i]) {
            index[count++] = i;
            shared = shared || memory[gb_lock_shared(n) + i] != 0.0;
        }
    }
    if (shared) {
        double A[count * count + 1], b[count + 1], lo[count + 1], hi[count + 1], x[count + 1], worst = 0.0, size = 0.0;
        for (int p = 0; p < count; p++) {
            const int i = index[p], own = memory[gb_lock_shared(n) + i] == 0.0;
            b[p] = 0.0;
            for (int q = 0; q < count; q++) {
                A[p * count + q] = matrix[i * n + index[q]];
                b[p] -= A[p * count + q] * held[index[q]];
            }
            lo[p] = own ? -HUGE_VAL : lower[i];
            hi[p] = own ? HUGE_VAL : fmax(lower[i], upper[i]);
        }
        gb_lock_box(count, A, b, lo, hi, x);
        for (int p = 0; p < count; p++) {
            double left = b[p], terms = fabs(b[p]);
            for (int q = 0; q < count; q++) {
                left += A[p * count + q] * x[q];
                terms += fabs(A[p * count + q] * x[q]);
            }
            worst = fmax(worst, memory[gb_lock_shared(n) + index[p]] != 0.0 ? fabs(left) : 0.0);
            size = fmax(size, terms);
        }
        for (int p = 0; p < count; p++) {
            held[index[p]] = x[p];
            excess[index[p]] = worst - 1e-11 * size - DBL_MIN;
        }
    }
    for (int i = 0; i < n; i++) {
        if (!stuck[i]) {
            excess[i] = -1.0;
        } else if (memory[gb_lock_shared(n) + i] == 0.0) {
            const double over = fmax(held[i] - upper[i], lower[i] - held[i]);
            excess[i] = over > -HUGE_VAL ? over : -1.0;
        }
    }
}

#endif
