/* Lossy gears beside a switch that slides along its limit: what drives on one side of it may be driven on the other, so
 * that each side has its own losses, and the mean is one of both motions (Filippov 1988, section 4):
 *     f_below with the signs of forces there,   f_above with those that it asks for.
 * Knows nothing of shares. */
#ifndef GB_TURNED_GEARS_H
#define GB_TURNED_GEARS_H

#include "gb_internal.h"

/* Beside one switch that slides alone: finds the gears whose force has the other sign above its limit, into
 * events.turned; 0: no signs agree with the forces there. */
int gb_turn_gears(gb_sim *sim);

/* The lossy gear that slides whose sign of the force event function i tells: its tie; else -1. */
int gb_sign_of_gear(const gb_sim *sim, int i);

/* The value of its event function agrees with a sign. largest: of values of which it may be the rounding. */
static inline int gb_sign_agrees(double sign, double value, double largest) {
    return sign > -0.5 ? value >= -1e-12 * largest : value <= 1e-12 * largest;
}

#endif
