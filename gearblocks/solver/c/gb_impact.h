/* Impacts: stops that are hit and unbounded constraints that close on a slip, all at once:
 *     G v+ = G v- + W p,   find p (impulses) with  G v+ >= -e G v-  complementary to p >= 0  (unbounded ones: G v+ =
 * 0), W the Delassus matrix, e the restitution (Newton). What opens (G v- > 0) takes no part, and is hit in the next
 * round where this turns it around. Friction with a bound transmits no impulse. Source: Pfeiffer
 * and Glocker 1996, with Newton's law in place of Poisson's. Knows nothing of forces. */
#ifndef GB_IMPACT_H
#define GB_IMPACT_H

#include "gb_internal.h"

/* Applies impulses where a stop is hit or an unbounded constraint slips; constraints.slip: slips after it. */
int gb_impact(gb_sim *sim);

#endif
