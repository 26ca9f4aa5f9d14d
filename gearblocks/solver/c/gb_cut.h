/* Whether a step in which an event was looked for is tried again with a part of its size, good as its estimate is: its
 * events could not be told, or the part before the first is wrong.
 * Assumed: the event functions that gb_locate just looked at, complete rows where there is an event.
 * Knows nothing of what an event does. */
#ifndef GB_CUT_H
#define GB_CUT_H

#include "gb_internal.h"

/* The part that is to be tried, 1: none. theta: of the first event, 2: none. */
double gb_part_in_question(gb_sim *sim, double theta);

/* The same; most steps have no event, and nothing in them is in doubt. */
static inline double gb_part_again(gb_sim *sim, double theta) {
    const int asked = theta < 1.0 || sim->events.undersampled || sim->events.in_doubt;
    return asked ? gb_part_in_question(sim, theta) : 1.0;
}

#endif
