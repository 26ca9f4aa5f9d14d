/* Constraint forces over a piece of a step. With constant rows and inertia they are
 *
 *     lambda = -W_aa^-1 G_a M^-1 tau = L tau,   excess over the bounds = max(lambda - upper, lower - lambda),
 *
 * L found column by column once in each mode, tau and the bounds enclosed. What does not follow from the torques so
 * (sets with redundant rows, large sets) is left to samples; so is a step at whose start the two differ. Knows nothing
 * of how crossings are located. */
#ifndef GB_FORCE_ENCLOSURE_H
#define GB_FORCE_ENCLOSURE_H

#include "gb_internal.h"

/* Responses of the active set; whether its constraint forces can be enclosed. */
int gb_forces_prepare(gb_sim *sim);

/* The event functions of constraint forces over the piece whose arguments are given. */
void gb_forces_enclose(gb_sim *sim);

/* Whether enclosures over hardly any time at the start of the step agree with the event functions there. */
int gb_forces_agree(gb_sim *sim);

/* Over the piece whose arguments are given constraint forces are inside their bounds, as their values tell: for this
 * piece, or for a box around what an earlier one had in these modes. Only where they have agreed. */
int gb_forces_inside(gb_sim *sim);

/* In the step just computed constraint forces are all that could end a mode, and by far they do not: without a look at
 * the polynomials of the step. Only where they have agreed in these modes. */
int gb_forces_stay(gb_sim *sim);

#endif
