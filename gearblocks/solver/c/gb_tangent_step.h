/* Tangents along a step: the derivative of the step itself. Assumed: an explicit method, modes that do not change in
 * it. Knows nothing of events. */
#ifndef GB_TANGENT_STEP_H
#define GB_TANGENT_STEP_H

#include "gb_tangent_room.h"

/* How far along v a difference goes: a small part of the size of each state. 0: v is zero. */
double gb_tangent_reach(const gb_sim *sim, const gb_tangent_room *room, const double *y, const double *v);

/* The columns along the step that ended at the front. */
int gb_tangents_step(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room);

#endif
