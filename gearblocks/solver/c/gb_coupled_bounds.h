/* Bounds of the unknowns of a complementarity problem that grow with another of them (gb_lcp.h).
 * Knows nothing of the problem. */
#ifndef GB_COUPLED_BOUNDS_H
#define GB_COUPLED_BOUNDS_H

/* Bounds that grow with another unknown: lo[i] x_p is added to the lower one, hi[i] x_p to the upper one, p = on[i]
 * (-1: they do not). NULL: none does. associated: at such a bound y_i pushes x_p too, by the slope of it, and x_p may
 * have bounds of its own. */
typedef struct gb_coupled_bounds {
    const int *on;
    const double *lo, *hi;
    int associated;
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

#endif
