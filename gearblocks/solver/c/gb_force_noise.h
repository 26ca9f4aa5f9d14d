/* What of a constraint force is none: rounding, and what moves nothing.
 * Assumed: the active set is factored.
 * Knows nothing of which set that is, and of steps but their size. */
#ifndef GB_FORCE_NOISE_H
#define GB_FORCE_NOISE_H

#include "gb_internal.h"

/* What rounding leaves of the force whose excess event function i tells, beside the forces of all active constraints.
 * force: its size. */
double gb_force_rounding(gb_sim *sim, int i, const double *time_terms, const double *y, double *force);

/* The same, and what is no more beside the speeds that it could change in the step at hand. */
double gb_force_noise(gb_sim *sim, int i, const double *time_terms, const double *y, double *force);

/* The part of that which follows from the speeds alone: such a force moves nothing in the step at hand. 0: nothing has
 * moved so far by more than `rounding`, that of the same force, does. */
double gb_idle_force(gb_sim *sim, int i, double rounding, const double *time_terms, const double *y);

#endif
