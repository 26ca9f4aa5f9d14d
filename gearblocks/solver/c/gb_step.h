/* One accepted step from the front: tried until its error is within the tolerance, cut at the first event inside it.
 * Knows methods as tables, switches only by where they are located. */
#ifndef GB_STEP_H
#define GB_STEP_H

#include "gb_internal.h"

/* One accepted step, to `stop` at most; marks what flips at its end. */
int gb_step(gb_sim *sim, double stop);

#endif
