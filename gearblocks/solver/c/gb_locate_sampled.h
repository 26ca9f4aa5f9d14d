/* Where event functions without enclosures (constraint forces, slips of prescribed motions) leave their mode: the first
 * th in [0, 1] with side (limit - s(th)) < 0, from true values at points along the step. Roots by false position with
 * the Illinois rule (Dowell and Jarratt 1971), dips between samples by golden section (Kiefer 1953); a constraint force
 * is looked at closer until what bends is small beside its distance to the bound. One that starts on its limit is
 * watched from its start value (armed). Knows nothing of what an event does. */
#ifndef GB_LOCATE_SAMPLED_H
#define GB_LOCATE_SAMPLED_H

#include "gb_internal.h"

/* All event functions at theta, into s. */
int gb_event_functions_at(gb_sim *sim, double theta, double *s);

/* Distance of event function i to its limit `side`; from its start value where it is armed there. */
double gb_limit_distance(const gb_sim *sim, int i, double side, double s);

/* The event functions [n_affine, n_event_functions) without enclosures; fills located and side. */
int gb_locate_sampled(gb_sim *sim);

#endif
