/* Rest on the limit of a condition: a law that jumps against the motion by more than a friction holds drives a body
 * back and forth about the limit, by less and less (Coulomb friction takes a part of each swing), and in a finite time
 * it is at rest there: stuck, and on neither side of the condition. Swings of a thousandth of the tolerance end in it,
 * and those that are about as wide as rounding can tell.
 * Knows nothing of how long it lasts. */
#ifndef GB_LIMIT_REST_H
#define GB_LIMIT_REST_H

#include "gb_internal.h"

/* Switch i, which has just flipped at the front, and a friction that slides come to rest on its limit; else returns 0.
 * since: the time between its last two flips; 0: of one that every mode drives back at once. settled: its swings become
 * no shorter, so that wider ones end too. */
int gb_come_to_rest(gb_sim *sim, int i, double since, int settled);

#endif
