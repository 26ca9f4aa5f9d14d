/* Flights from a stop: which of them there are, and which are nothing that time or the gap could tell from rest.
 * Knows nothing of what an impact does. */
#ifndef GB_FLIGHT_H
#define GB_FLIGHT_H

#include "gb_internal.h"

/* What an impact did to a constraint that it struck: nothing of its slip is left where it came to rest. */
enum { GB_STRUCK = 1, GB_STRUCK_TO_REST };

/* The restitution of stop i, which is struck. It comes to rest where what presses it brings it back from nothing but
 * such a flight; how long the last flight was does not tell, it may have been the first or have ended at a body that
 * came its way. */
double gb_restitution(gb_sim *sim, int i);

/* Stop i is struck after a flight that, all of it, cannot be told from rest. */
int gb_ends_for_nothing(gb_sim *sim, int i);

/* An impact elsewhere has opened stop i, which was closed or has just been struck to rest: what presses it brings it
 * back before the flight could be told from rest. */
int gb_opens_for_nothing(gb_sim *sim, int i);

/* A body at stop i, at rest and open, is pulled away from it: whatever strikes the body an instant later finds it
 * apart, and drives it back onto the stop in an impact of its own. Where a run begins nothing has been left. */
int gb_is_being_left(gb_sim *sim, int i);

#endif
