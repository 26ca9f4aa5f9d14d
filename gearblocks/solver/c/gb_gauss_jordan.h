/* A x = b  by Gauss-Jordan elimination with row exchanges, for small dense A. Knows nothing of what A is. */
#ifndef GB_GAUSS_JORDAN_H
#define GB_GAUSS_JORDAN_H

#include <math.h>

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

#endif
