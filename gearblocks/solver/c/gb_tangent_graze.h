/* Steps in which an event function turns at its limit: motions beside reach it, or do not, and no derivative exists.
 * Assumed: gb_tangents_step has been called for the step. Knows nothing of events that are located. */
#ifndef GB_TANGENT_GRAZE_H
#define GB_TANGENT_GRAZE_H

#include "gb_tangent_room.h"

/* Of the step that ended at the front. */
int gb_tangents_graze(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room);

#endif
