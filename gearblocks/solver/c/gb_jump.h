/* Where a step has to end, and steps too short to be told from rounding: the front jumps.
 * Knows nothing of how steps are made. */
#ifndef GB_JUMP_H
#define GB_JUMP_H

#include "gb_internal.h"

/* The first instant that no step passes. */
double gb_limit_of_step(const gb_sim *sim, double stop);

/* The front is there but for rounding. */
int gb_is_at(const gb_sim *sim, double limit);

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
