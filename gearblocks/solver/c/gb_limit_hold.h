/* Rest on the limit of a condition over coordinates without a friction: where a torque jumps there and both of its
 * sides drive back, what is at rest on the limit, or goes with it, stays, on the mean of both (Filippov 1960, of the
 * second degree): s(q, t) = 0,  s' = 0,  s'' = (1 - share) s''(below) + share s''(above) = 0. Swings that are lower
 * than the tolerance end so, by an impulse of the torque that jumps. Knows nothing of how long it lasts. */
#ifndef GB_LIMIT_HOLD_H
#define GB_LIMIT_HOLD_H

#include "gb_internal.h"

/* The last of those that slide, in its mode below, is at rest on its limit, or by the speeds that it leaves; its last
 * flip was so long ago. Else returns 0. */
int gb_hold_last(gb_sim *sim, double since);

/* How fast the limit of the switch that is held as number j may go: what the tolerances of speeds admit. */
void gb_admit(gb_sim *sim, int j);

#endif
