/* Friction whose capacity jumps over a limit that slides: what its modes are meanwhile, and where it sticks.
 * Assumed: the switch that slides is in its lower mode, the upper one is by 1 higher (gb_sliding.h).
 * Knows nothing of shares and of when a switch slides. */
#ifndef GB_SLIDING_FRICTION_H
#define GB_SLIDING_FRICTION_H

#include "gb_internal.h"

/* Friction with a capacity of exactly 0 on one side of switch i, free there, rubs on both sides where the mode of the
 * switch lies between both: with nothing on that one. In another mode it is what that one asks. */
void gb_rub_on_both_sides(gb_sim *sim, int i, double mode);

/* The side of the sliding switch i on which friction c, whose slip ends at the front, holds more: of its mode 0, or 1;
 * -1 where both are alike, or it slips on. With the mean of both it could not stick. */
int gb_stronger_side(gb_sim *sim, int i, int c);

#endif
