/* Where event functions without enclosures (constraint forces, slips of prescribed motions) leave their mode: the first
 * th in [0, 1] with side (limit - s(th)) < 0, from true values at points along the step and at the first event that is
 * known. A constraint force is looked at closer until what bends is small beside its distance to the bound. One that
 * starts on its limit is watched from its start value (armed). Knows nothing of what an event does. */
#ifndef GB_LOCATE_SAMPLED_H
#define GB_LOCATE_SAMPLED_H

#include "gb_internal.h"

/* The event functions [n_affine, n_event_functions) without enclosures; fills located and side. */
int gb_locate_sampled(gb_sim *sim);

#endif
