/* Where event functions that are affine in the state leave their mode: the first th in [0, 1] with s(th) beyond a
 * limit. The polynomial of s along the step (gb_dense_output.h) is exact, so that it can be sampled at eighths and
 * followed to interior extrema; a double crossing inside a step is found. Roots by Newton's method kept inside by
 * bisection. A switch on its limit (armed: it has just flipped, or starts there) is watched through (s(th) - s(0)) /
 * th: the root at th = 0 is divided out, a second crossing is not. Knows nothing of what an event does. */
#ifndef GB_LOCATE_POLYNOMIAL_H
#define GB_LOCATE_POLYNOMIAL_H

#include "gb_internal.h"

/* The affine event functions; fills located and side. */
int gb_locate_affine(gb_sim *sim, double tolerance);

#endif
