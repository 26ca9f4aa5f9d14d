/* Limits of conditions on which it does not matter which side is taken: nothing moves otherwise on the other one.
 * Knows nothing of what slides. */
#ifndef GB_LIMIT_STAY_H
#define GB_LIMIT_STAY_H

#include "gb_internal.h"

/* Switch i stays on its limit, which is not watched for a while: a joint that is stuck holds the state
 * on a corner of its law, or the force of the joint makes up for a law that jumps, and on which side rounding puts it
 * tells the motion apart no more than a thousandth of the tolerance. Returns 0 where more depends on the side. */
int gb_stay_on_limit(gb_sim *sim, int i);

#endif
