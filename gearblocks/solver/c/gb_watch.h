/* Outputs that are watched along the steps of a run (gb_watch of gb_core.h): at every accepted step and event, where
 * a step ends with the time terms and the rates of its last stage. Of an output f with the limit L:
 *
 *   L > 0: how often |f| comes to exceed L;   L = 0: how often f changes its sign, where |f| is more than 10 rtol of
 * its largest value so far
 *
 * The first time lies on the straight line between two steps. A step from event to event is looked at in its middle
 * too, where f is at its limit at both; else what happens and ends within a step is not seen. Knows nothing of what
 * an output means. */
#ifndef GB_WATCH_H
#define GB_WATCH_H

#include "gb_internal.h"

/* What stands at the front, after a step or an event. */
int gb_watches_take(gb_sim *sim, gb_watches *all, int is_step);

#endif
