/* Lossy gears: what they lose depends on the direction in which they slide and on the sign of the force that they
 * carry, and both on what they lose. Modes: at rest, or direction times sign. Every combination of all of them is
 * tried; the accelerations of those that hold true must agree.
 * Assumed: few of them (5^n combinations).
 * Knows nothing of events. */
#ifndef GB_LOSSY_GEAR_H
#define GB_LOSSY_GEAR_H

#include "gb_internal.h"

/* The train has any. */
int gb_has_lossy(const gb_sim *sim);

/* As gb_choose_active_set, for every combination; the one that holds true is taken. */
int gb_choose_lossy(gb_sim *sim);

#endif
