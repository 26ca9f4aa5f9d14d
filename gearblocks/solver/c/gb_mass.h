/* M x = b with the mass matrix of coupled groups, M = L D L' on a fixed pattern;  A x = b with the balance of massless
 * groups, A = L D U on a fixed symmetric pattern.
 * Assumed: M is symmetric positive definite, so that no pivoting is needed. A may be singular: a pivot below 1e-13 of
 * the terms that made it is none, and its unknown is 0.
 * Method: right-looking elimination in a given order (George and Liu 1981).
 * Knows nothing of what is coupled. */
#ifndef GB_MASS_H
#define GB_MASS_H

#include "gb_model.h"

#include <float.h>
#include <math.h>

/* diag by elimination step, becomes 1/D; lower by place, becomes L. */
static inline void gb_mass_factor(const gb_pattern *p, double *diag, double *lower) {
    int pair = 0;
    for (int k = 0; k < p->n; k++) {
        const double inverse = 1.0 / diag[k];
        for (int i = p->start[k]; i < p->start[k + 1]; i++) {
            const double factor = lower[i] * inverse;
            diag[p->row[i]] -= factor * lower[i];
            for (int j = i + 1; j < p->start[k + 1]; j++) {
                lower[p->pair[pair++]] -= factor * lower[j];
            }
        }
        for (int i = p->start[k]; i < p->start[k + 1]; i++) {
            lower[i] *= inverse;
        }
        diag[k] = inverse;
    }
}

/* x becomes the solution; x is numbered as the unknowns. */
static inline void gb_mass_solve(const gb_pattern *p, const double *diag, const double *lower, double *x) {
    for (int k = 0; k < p->n; k++) {
        for (int i = p->start[k]; i < p->start[k + 1]; i++) {
            x[p->order[p->row[i]]] -= lower[i] * x[p->order[k]];
        }
    }
    for (int k = p->n - 1; k >= 0; k--) {
        double sum = diag[k] * x[p->order[k]];
        for (int i = p->start[k]; i < p->start[k + 1]; i++) {
            sum -= lower[i] * x[p->order[p->row[i]]];
        }
        x[p->order[k]] = sum;
    }
}

/* A matrix that is not symmetric, as L D U: diag by step becomes 1/D (0 for a pivot that is none), lower becomes L,
 * upper becomes D U. Returns the number of pivots that are none. */
static inline int gb_balance_factor(const gb_pattern *p, double *diag, double *lower, double *upper) {
    int pair = 0, lost = 0;
    double size[p->n + 1];
    for (int k = 0; k < p->n; k++) {
        size[k] = fabs(diag[k]);
    }
    for (int k = 0; k < p->n; k++) {
        const int none = !(fabs(diag[k]) > 1e-13 * size[k]);
        const double inverse = none ? 0.0 : 1.0 / diag[k];
        lost += none;
        for (int i = p->start[k]; i < p->start[k + 1]; i++) {
            lower[i] *= inverse;
            diag[p->row[i]] -= lower[i] * upper[i];
            size[p->row[i]] = fmax(size[p->row[i]], fabs(lower[i] * upper[i]));
        }
        for (int i = p->start[k]; i < p->start[k + 1]; i++) {
            for (int j = i + 1; j < p->start[k + 1]; j++, pair++) {
                lower[p->pair[pair]] -= lower[j] * upper[i];
                upper[p->pair[pair]] -= lower[i] * upper[j];
            }
        }
        diag[k] = inverse;
    }
    return lost;
}

/* A difference that is less than this part of its terms is rounding: a speed that a force unknown holds at 0 is 0, and
 * not the rounding of that force. */
#define GB_BALANCED (64.0 * DBL_EPSILON)

/* x becomes the solution; x is numbered as the unknowns. */
static inline void gb_balance_solve(const gb_pattern *p, const double *diag, const double *lower, const double *upper,
                                    double *x) {
    double largest[p->n + 1]; /* of the terms that a right side is made of */
    for (int k = 0; k < p->n; k++) {
        largest[k] = fabs(x[p->order[k]]);
    }
    for (int k = 0; k < p->n; k++) {
        for (int i = p->start[k]; i < p->start[k + 1]; i++) {
            const double term = lower[i] * x[p->order[k]];
            x[p->order[p->row[i]]] -= term;
            largest[p->row[i]] = fmax(largest[p->row[i]], fabs(term));
        }
    }
    for (int k = p->n - 1; k >= 0; k--) {
        double sum = x[p->order[k]], size = largest[k];
        for (int i = p->start[k]; i < p->start[k + 1]; i++) {
            const double term = upper[i] * x[p->order[p->row[i]]];
            sum -= term;
            size = fmax(size, fabs(term));
        }
        x[p->order[k]] = fabs(sum) < GB_BALANCED * size ? 0.0 : diag[k] * sum;
    }
}

#endif
