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
double gb_rate_rounding(const gb_sim *sim, int i, double size);

/* Candidates that cannot be held slide, until all others can. */
int gb_weigh(gb_sim *sim);

/* The force on lock i after `weigh`, and its slip acceleration with all of them. */
double gb_weighed_force(const gb_sim *sim, int i);

double gb_weighed_rate(const gb_sim *sim, int i, double *size);

#endif
