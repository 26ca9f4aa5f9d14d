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

#endif
