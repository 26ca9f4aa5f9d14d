/* Box-constrained linear complementarity problem:  find lo <= x <= hi with  y = A x + b,
 *     y_i >= 0 where x_i = lo_i,   y_i <= 0 where x_i = hi_i,   y_i = 0 between.
 * A: principal minors positive (symmetric positive definite: one solution), or positive semidefinite where rows are
 * redundant: y is still unique, of the x about the smallest is taken.
 * Method: block principal pivoting with a least index rule as a way out of cycles (Judice and Pires 1994); for a
 * singular A proximal steps,  (A + e I) x+ + b - e x  in place of  A x + b  (Rockafellar 1976). And  A x = b  by
 * Gauss-Jordan elimination with row exchanges.
 * Knows nothing of slips, modes or time. */
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

/* The unknowns inside their bounds, from those at a bound: x of the `free` ones in inside[]. */
static inline void gb_lcp_inside(int n, const double *A, const double *b, const int *side, int free, const int *inside,
                                 double *x) {
    double part[n * n + 1], right[n + 1];
    for (int p = 0; p < free; p++) {
        right[p] = -b[inside[p]];
        for (int j = 0; j < n; j++) {
            right[p] -= side[j] ? A[inside[p] * n + j] * x[j] : 0.0;
        }
        for (int q = 0; q < free; q++) {
            part[p * free + q] = A[inside[p] * n + inside[q]];
        }
    }
    gb_gauss_jordan(free, free, part, 1, right);
    for (int p = 0; p < free; p++) {
        x[inside[p]] = right[p];
    }
}

/* Where each unknown should be instead, -1, 0 or 1 as `side`; returns how many are elsewhere, the last of them in
 * *last. */
static inline int gb_lcp_misplaced(int n, const double *A, const double *b, const double *lo, const double *hi,
                                   const double *x, const int *side, int *want, int *last) {
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
            want[i] = x[i] < lo[i] ? -1 : x[i] > hi[i];
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
                                  double *x) {
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
        gb_lcp_inside(n, A, b, side, free, inside, x);
        const int bad = gb_lcp_misplaced(n, A, b, lo, hi, x, side, want, &last);
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

/* The same for a matrix that may be singular: among the solutions about the smallest x, by steps of a proximal method.
 */
static inline int gb_lcp_solve(int n, const double *A, const double *b, const double *lo, const double *hi, double *x) {
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
        if (!gb_lcp_pivoting(n, lifted, right, lo, hi, x)) {
            return 0;
        }
    }
    return 1;
}

#endif
