/* Tangents across an event: saltation, and a difference of whole events where it changes the state. Knows nothing of
 * steps. */
#ifndef GB_TANGENT_EVENT_H
#define GB_TANGENT_EVENT_H

#include "gb_tangent_room.h"

/* An instant at which no derivative exists. */
void gb_tangents_note(gb_tangents *tangents, double t);

/* What is pending at the front, before it is applied and after. */
int gb_tangents_before(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room);
int gb_tangents_after(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room);

#endif
