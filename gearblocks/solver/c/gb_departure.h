/* Event functions that stand on a limit, with no slope there: a condition over the angle of a shaft that several
 * springs part from the load, in a train that begins to move. It leaves its limit like a high power of time, below all
 * that the rounding and the tolerance of a step can tell, and a sign there would be chance. The motion is followed in
 * the present modes until the side is plain; the mode is that of this side, and until then the limit is not watched.
 * Knows nothing of how steps are made. */
#ifndef GB_DEPARTURE_H
#define GB_DEPARTURE_H

#include "gb_internal.h"

/* After the start or an event (before: as of gb_balance_massless; timed: of time): decides those that stand on a limit.
 */
int gb_depart(gb_sim *sim, int before, int timed);

#endif
