/* Which candidates of the switched constraints stay active, and with which forces:
 *     slip acceleration = free acceleration + W lambda,   lo <= lambda <= hi,
 * zero where lambda is inside its bounds, along the free side at a bound (gb_lcp.h): that constraint slides from here.
 * Assumed: slips are zero; bounds do not depend on lambda (those of lossy gears do: gb_lossy_gear.c).
 * Source: Pfeiffer and Glocker 1996, on the level of accelerations.
 * Knows nothing of events. */
#ifndef GB_CONSTRAINT_FORCES_H
#define GB_CONSTRAINT_FORCES_H

#include "gb_internal.h"

/* What cannot be told from zero in a slip acceleration whose terms add up to `size`. */
double gb_acceleration_rounding(const gb_sim *sim, int i, double size);

/* The rates at a state in the present modes, with no constraint active. */
void gb_free_rates(gb_sim *sim, const double *time_terms, const double *y, double *rates);

/* Solves for the active set: candidates that no force within its bounds keeps from slipping slide, until all others
 * stay. */
int gb_choose_active_set(gb_sim *sim);

/* After gb_choose_active_set: the slip acceleration of constraint i with all forces; size: sum of its terms. */
double gb_slip_acceleration(const gb_sim *sim, int i, double *size);

/* What rounding leaves of the force whose excess event function i tells, beside the forces of all active constraints.
 * force: its size. */
double gb_force_rounding(gb_sim *sim, int i, const double *time_terms, const double *y, double *force);

/* The same, and what is no more beside the speeds that it could change in the step at hand. */
double gb_force_noise(gb_sim *sim, int i, const double *time_terms, const double *y, double *force);

/* The part of that which follows from the speeds alone: such a force moves nothing in the step at hand. */
double gb_idle_force(gb_sim *sim, int i, const double *time_terms, const double *y);

#endif
