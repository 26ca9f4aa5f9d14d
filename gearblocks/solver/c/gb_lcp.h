/* Box-constrained linear complementarity problem:  find lo <= x <= hi with  y = A x + b,
 *     y_i >= 0 where x_i = lo_i,   y_i <= 0 where x_i = hi_i,   y_i = 0 between.
 * A: principal minors positive (symmetric positive definite: one solution), or positive semidefinite where rows are
 * redundant: y is still unique, of the x about the smallest is taken. Bounds may grow with another unknown that has
 * none (friction in proportion to a force); A with such columns may have no solution, or several. Method: block
 * principal pivoting with a least index rule as a way out of cycles (Judice and Pires 1994); for a singular A proximal
 * steps,  (A + e I) x+ + b - e x  in place of  A x + b  (Rockafellar 1976). And  A x = b  by Gauss-Jordan elimination
 * with row exchanges. Knows nothing of slips, modes or time. */
#ifndef GB_LCP_H
#define GB_LCP_H

#include <float.h>
#include <math.h>
#include <string.h>

/* Solves A x = b for n unknowns with row exchanges; A (row length `stride`) and b are overwritten. 0: singular. */
static inline int gb_gauss_jordan(int n, int stride, double *A, int n_right, double *b) {
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

/* Bounds that grow with another unknown: lo[i] x_p is added to the lower one, hi[i] x_p to the upper one, p = on[i]
 * (-1: they do not). NULL: none does. */
typedef struct gb_coupled_bounds {
    const int *on;
    const double *lo, *hi;
} gb_coupled_bounds;

/* By how much the lower (side < 0) or upper bound of unknown i grows with another one. */
static inline double gb_lcp_slope(const gb_coupled_bounds *coupled, int i, int side) {
    return coupled && coupled->on[i] >= 0 ? (side < 0 ? coupled->lo[i] : coupled->hi[i]) : 0.0;
}

/* What is added to that bound. */
static inline double gb_lcp_shift(const gb_coupled_bounds *coupled, int i, int side, const double *x) {
    const double slope = gb_lcp_slope(coupled, i, side);
    return slope != 0.0 ? slope * x[coupled->on[i]] : 0.0;
}

/* The unknowns inside their bounds, from those at a bound: x of the `free` ones in inside[]; what bounds of others take
 * of them comes on top of x of the others. */
static inline void gb_lcp_inside(int n, const double *A, const double *b, const gb_coupled_bounds *coupled,
                                 const int *side, int free, const int *inside, double *x) {
    double part[n * n + 1], right[n + 1];
    for (int p = 0; p < free; p++) {
        right[p] = -b[inside[p]];
        for (int j = 0; j < n; j++) {
            right[p] -= side[j] ? A[inside[p] * n + j] * x[j] : 0.0;
        }
        for (int q = 0; q < free; q++) {
            part[p * free + q] = A[inside[p] * n + inside[q]];
            for (int j = 0; j < n && coupled; j++) {
                part[p * free + q] += side[j] && coupled->on[j] == inside[q]
                                          ? A[inside[p] * n + j] * gb_lcp_slope(coupled, j, side[j])
                                          : 0.0;
            }
        }
    }
    gb_gauss_jordan(free, free, part, 1, right);
    for (int p = 0; p < free; p++) {
        x[inside[p]] = right[p];
    }
    for (int j = 0; j < n && coupled; j++) {
        x[j] += side[j] ? gb_lcp_shift(coupled, j, side[j], x) : 0.0;
    }
}

/* Where each unknown should be instead, -1, 0 or 1 as `side`; returns how many are elsewhere, the last of them in
 * *last. */
static inline int gb_lcp_misplaced(int n, const double *A, const double *b, const double *lo, const double *hi,
                                   const gb_coupled_bounds *coupled, const double *x, const int *side, int *want,
                                   int *last) {
    int bad = 0;
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
            const double least = lo[i] + gb_lcp_shift(coupled, i, -1, x), most = hi[i] + gb_lcp_shift(coupled, i, 1, x);
            want[i] = x[i] < least ? -1 : x[i] > most;
        } else if (side[i] < 0 ? w < -rounding : w > rounding) {
            want[i] = 0;
        }
        if (want[i] != side[i]) {
            *last = i;
            bad++;
        }
    }
    return bad;
}

/* Block principal pivoting. All that are misplaced change at once, after ten rounds without fewer of them the last one
 * alone (a least index rule, counted from behind). 0: not found. */
static inline int gb_lcp_pivoting(int n, const double *A, const double *b, const double *lo, const double *hi,
                                  const gb_coupled_bounds *coupled, double *x) {
    int side[n + 1], inside[n + 1], want[n + 1], fewest = n + 1, patience = 10;
    for (int i = 0; i < n; i++) {
        side[i] = 0;
    }
    for (int round = 0; round < 60 + 20 * n; round++) {
        int free = 0, last = -1;
        for (int i = 0; i < n; i++) {
            if (side[i] == 0) {
                inside[free++] = i;
            } else {
                x[i] = side[i] < 0 ? lo[i] : hi[i];
            }
        }
        gb_lcp_inside(n, A, b, coupled, side, free, inside, x);
        const int bad = gb_lcp_misplaced(n, A, b, lo, hi, coupled, x, side, want, &last);
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
            side[i] = patience > 0 || i == last ? want[i] : side[i];
        }
    }
    return 0;
}

/* One proximal step as a correction of x: what is left of the equations is solved for, so that the rounding of a matrix
 * that is nearly singular does not stay in them. 2: by no more than rounding; 0: not found. */
static inline int gb_lcp_correct(int n, const double *A, const double *lifted, const double *b, const double *lo,
                                 const double *hi, const gb_coupled_bounds *coupled, double *x) {
    double left[n + 1], least[n + 1], most[n + 1], step[n + 1];
    for (int i = 0; i < n; i++) {
        left[i] = b[i];
        for (int j = 0; j < n; j++) {
            left[i] += A[i * n + j] * x[j];
        }
        least[i] = lo[i] + gb_lcp_shift(coupled, i, -1, x) - x[i];
        most[i] = hi[i] + gb_lcp_shift(coupled, i, 1, x) - x[i];
    }
    if (!gb_lcp_pivoting(n, lifted, left, least, most, coupled, step)) {
        return 0;
    }
    double moved = 0.0, largest = 0.0;
    for (int i = 0; i < n; i++) {
        x[i] += step[i];
        moved = fmax(moved, fabs(step[i]));
        largest = fmax(largest, fabs(x[i]));
    }
    for (int i = 0; i < n; i++) { /* at a bound means exactly there */
        for (int side = -1; side <= 1; side += 2) {
            const double bound = (side < 0 ? lo[i] : hi[i]) + gb_lcp_shift(coupled, i, side, x);
            const int met = fabs(bound) < HUGE_VAL && fabs(x[i] - bound) <= 8.0 * DBL_EPSILON * fabs(bound);
            x[i] = met ? bound : x[i];
        }
    }
    return moved <= 1e-13 * largest ? 2 : 1;
}

/* The same for a matrix that may be singular: among the solutions about the smallest x, by steps of a proximal method.
 */
static inline int gb_lcp_solve(int n, const double *A, const double *b, const double *lo, const double *hi,
                               const gb_coupled_bounds *coupled, double *x) {
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
        const int found = coupled ? gb_lcp_correct(n, A, lifted, b, lo, hi, coupled, x)
                                  : gb_lcp_pivoting(n, lifted, right, lo, hi, NULL, x);
        if (found != 1) {
            return found;
        }
    }
    return 1;
}

#endif
