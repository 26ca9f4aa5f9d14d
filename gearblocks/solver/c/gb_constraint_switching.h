/* Which switched constraints are active after an event, all decided together: impacts first (gb_impact.c); then all
 * that does not slip is a candidate, and the forces that would keep every slip at zero, each within its bounds, decide
 * (gb_constraint_forces.c, gb_lossy_gear.c). Both problems have one solution for the motion, whatever the order. Where
 * forces and bounds vanish together the state a little ahead decides.
 * Knows nothing of steps. */
#ifndef GB_CONSTRAINT_SWITCHING_H
#define GB_CONSTRAINT_SWITCHING_H

#include "gb_internal.h"

/* Decides about all switched constraints at the front; with `log` what changes is an event. */
int gb_switch_constraints(gb_sim *sim, int log);

#endif
