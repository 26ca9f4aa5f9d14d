/* Sliding along the limit of a condition (Filippov 1960): where a law jumps against the motion, so that both of its
 * modes drive the state back to the limit, the motion stays there, on the mean of both that gb_rates.h forms, as long
 * as its shares lie in 0..1. A controller that goes on and off holds its speed so.
 * Assumed: switched constraints hold what the mean and the lower sides ask of them, and other conditions stay in their
 * modes on either side (else the run stops, as it does where a limit is no place to stay).
 * Knows nothing of methods and of how a limit is reached. */
#ifndef GB_SLIDING_H
#define GB_SLIDING_H

#include "gb_internal.h"

/* Switch i, which goes back and forth at the front, slides from here on if both sides drive it back; else returns 0. */
int gb_slide(gb_sim *sim, int i);

/* Switch i over coordinates, whose accelerations both sides drive back, is held on its limit from here on by the mean
 * of both (see gb_limit_hold.h); since: its last flip but one. Else returns 0. */
int gb_hold(gb_sim *sim, int i, double since);

/* Switch i slides no longer, and goes on in a mode at its limit. */
void gb_leave_sliding(gb_sim *sim, int i, double mode);

/* Friction whose slip ends here leaves the limits over which its capacity jumps, to the side on which it holds more:
 * with the mean, it could not be stuck. */
int gb_leave_at_rest(gb_sim *sim);

/* What comes to rest beside sliding, and would be held by the mean alone, sticks. */
void gb_stick_by_mean(gb_sim *sim);

/* Something has changed at the front: what no longer holds on its limit leaves it. */
int gb_settle_sliding(gb_sim *sim);

/* The first theta of the step just computed where a share leaves 0..1, if that is before `theta`; marks its switch. */
int gb_sliding_end(gb_sim *sim, double *theta);

#endif
