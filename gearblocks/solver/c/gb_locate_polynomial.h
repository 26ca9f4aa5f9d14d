/* Where event functions leave their mode: the first th in [0, 1] with s(th) beyond a limit. s affine in the state: its
 * polynomial along the step (gb_dense_output.h) is exact, so that it can be sampled at eighths and followed to
 * interior extrema; a double crossing inside a step is found. Roots by Newton's method kept inside by bisection. A
 * switch on its limit (armed: it has just flipped, or starts there) is watched through (s(th) - s(0)) / th: the root
 * at th = 0 is divided out, a second crossing is not. Others: gb_locate_sampled.c.
 * Knows nothing of what an event does. */
#ifndef GB_LOCATE_POLYNOMIAL_H
#define GB_LOCATE_POLYNOMIAL_H

#include "gb_internal.h"

/* The first event inside the step just computed, as theta (2: none); all switches that flip there are marked. */
int gb_locate(gb_sim *sim, double *theta);

#endif
