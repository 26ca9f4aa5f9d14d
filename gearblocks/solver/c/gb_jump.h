/* Where a step has to end, and steps too short to be told from rounding: the front jumps.
 * Knows nothing of how steps are made. */
#ifndef GB_JUMP_H
#define GB_JUMP_H

#include "gb_internal.h"
#include "gb_vector.h"

/* The first instant that no step passes. */
static inline double gb_limit_of_step(const gb_sim *sim, double stop) {
    return gb_min(gb_min(sim->head->events.t_break, stop), sim->head->events.held_until);
}

/* The front is there but for rounding. */
static inline int gb_is_at(const gb_sim *sim, double limit) {
    return limit - sim->head->front.t1 <= 4.0 * DBL_EPSILON * fabs(sim->head->front.t1);
}

/* To an instant that was announced. */
int gb_jump(gb_sim *sim, double t);

/* No step from the front is short enough. From rest that is so where the motion begins at a corner of a callback: all
 * of a trial is error then. The front passes it by a few roundings of time, in which nothing moves; not twice in a row.
 */
int gb_passes_corner(gb_sim *sim);

/* A callback jumps within the step just tried: no step goes beyond that any more, and the try is to be made again.
 * Where the callback fails, code is what it said. */
int gb_ends_at_jump(gb_sim *sim, double stop, double *limit, int *code);

#endif
