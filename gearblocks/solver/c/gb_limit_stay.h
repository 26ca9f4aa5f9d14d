/* Limits of conditions on which it does not matter which side is taken: nothing moves otherwise on the other one. What
 * has faded away swings through zero with the error of implicit steps, or with rounding, and so does a state that a
 * stuck joint holds on a corner of its law. Knows nothing of what slides. */
#ifndef GB_LIMIT_STAY_H
#define GB_LIMIT_STAY_H

#include "gb_internal.h"

/* How far off its limit is idle for switch i, a thousandth of the tolerance, where it has flipped less than a step
 * before the one just computed, was located in that, is no farther off than so at its ends, and motions on both sides
 * come apart by no more; else 0. */
double gb_swings_idly(gb_sim *sim, int i, double far);

#endif
