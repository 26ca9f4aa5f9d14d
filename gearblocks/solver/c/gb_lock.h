/* Small dense algebra of what sticks: which rows are independent, the forces that hold them, and how redundant ones
 * share a load. Knows nothing of laws.
 *
 * Row i is a form of the speeds, the slip of lock i. While locks are stuck their memory (behind the modes) tells which
 * rows hold, the inverse of the matrix of their responses, and the rows in reduced form, solved for one speed each.
 */
#ifndef GB_LOCK_H
#define GB_LOCK_H

#include <float.h>
#include <math.h>
#include <string.h>

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

/* Solves A x = b for n unknowns with row exchanges; A (row length `stride`) and b are overwritten. 0: singular. */
static inline int gb_lock_solve(int n, int stride, double *A, int n_right, double *b) {
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++) {
            best = fabs(A[i * stride + k]) > fabs(A[best * stride + k]) ? i : best;
        }
        if (!(fabs(A[best * stride + k]) > 0.0)) {
            return 0;
        }
        for (int j = 0; j < n; j++) {
            const double swap = A[k * stride + j];
            A[k * stride + j] = A[best * stride + j];
            A[best * stride + j] = swap;
        }
        for (int j = 0; j < n_right; j++) {
            const double swap = b[k * n_right + j];
            b[k * n_right + j] = b[best * n_right + j];
            b[best * n_right + j] = swap;
        }
        for (int i = 0; i < n; i++) {
            const double factor = i == k ? 0.0 : A[i * stride + k] / A[k * stride + k];
            for (int j = k; j < n && factor != 0.0; j++) {
                A[i * stride + j] -= factor * A[k * stride + j];
            }
            for (int j = 0; j < n_right && factor != 0.0; j++) {
                b[i * n_right + j] -= factor * b[k * n_right + j];
            }
        }
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n_right; j++) {
            b[i * n_right + j] /= A[i * stride + i];
        }
    }
    return 1;
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

/* lo <= x <= hi with x = lo where w > 0, hi where w < 0, w = A x + b: block principal pivoting (Judice and Pires, 1994)
 * on a matrix with positive principal minors. 0: not found. */
static inline int gb_lock_pivoting(int n, const double *A, const double *b, const double *lo, const double *hi,
                                   double *x) {
    double part[n * n + 1], right[n + 1];
    int side[n + 1], inside[n + 1], fewest = n + 1, patience = 10;
    for (int i = 0; i < n; i++) {
        side[i] = 0;
    }
    for (int round = 0; round < 60 + 20 * n; round++) {
        int free = 0, bad = 0, first = -1;
        for (int i = 0; i < n; i++) {
            if (side[i] == 0) {
                inside[free++] = i;
            } else {
                x[i] = side[i] < 0 ? lo[i] : hi[i];
            }
        }
        for (int p = 0; p < free; p++) {
            right[p] = -b[inside[p]];
            for (int j = 0; j < n; j++) {
                right[p] -= side[j] ? A[inside[p] * n + j] * x[j] : 0.0;
            }
            for (int q = 0; q < free; q++) {
                part[p * free + q] = A[inside[p] * n + inside[q]];
            }
        }
        gb_lock_solve(free, free, part, 1, right);
        for (int p = 0; p < free; p++) {
            x[inside[p]] = right[p];
        }
        int want[n + 1];
        double largest = 0.0; /* its rounding passes into all the others */
        for (int i = 0; i < n; i++) {
            largest = fmax(largest, fabs(x[i]));
        }
        for (int i = 0; i < n; i++) {
            double w = b[i], size = fabs(b[i]);
            for (int j = 0; j < n && side[i]; j++) {
                w += A[i * n + j] * x[j];
                size += fabs(A[i * n + j]) * largest;
            }
            const double rounding = 16.0 * DBL_EPSILON * size;
            want[i] = side[i];
            if (side[i] == 0) {
                want[i] = x[i] < lo[i] ? -1 : x[i] > hi[i];
            } else if (side[i] < 0 ? w < -rounding : w > rounding) {
                want[i] = 0;
            }
            if (want[i] != side[i]) {
                first = i; /* the last one: a least index rule, counted from behind */
                bad++;
            }
        }
        if (bad == 0) {
            return 1;
        }
        if (bad < fewest) {
            fewest = bad;
            patience = 10;
        } else {
            patience--;
        }
        for (int i = 0; i < n; i++) {
            side[i] = patience > 0 || i == first ? want[i] : side[i];
        }
    }
    return 0;
}

/* The same for a matrix that may be singular: among the solutions about the smallest x, by steps of a proximal method.
 */
static inline int gb_lock_box(int n, const double *A, const double *b, const double *lo, const double *hi, double *x) {
    double lifted[n * n + 1], right[n + 1], most = 0.0;
    for (int i = 0; i < n; i++) {
        x[i] = 0.0;
        most = fmax(most, fabs(A[i * n + i]));
    }
    const double lift = most > 0.0 ? 1e-9 * most : 1.0;
    memcpy(lifted, A, sizeof(double) * (size_t)(n * n));
    for (int i = 0; i < n; i++) {
        lifted[i * n + i] += lift;
    }
    for (int round = 0; round < 4; round++) {
        for (int i = 0; i < n; i++) {
            right[i] = b[i] - lift * x[i];
        }
        if (!gb_lock_pivoting(n, lifted, right, lo, hi, x)) {
            return 0;
        }
    }
    return 1;
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
