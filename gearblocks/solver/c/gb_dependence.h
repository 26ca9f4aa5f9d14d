/* What else depends on a switch that slides along its limit: constraints that pass on the torque that jumps there, and
 * other conditions that the sides tell apart. Knows nothing of how long they last. */
#ifndef GB_DEPENDENCE_H
#define GB_DEPENDENCE_H

#include "gb_internal.h"

/* Whether another switch asks for the torque that slides by these shares, at the time terms at hand and the state y.
 * settles: what holds by the mean alone is not searched for events from here on. */
int gb_others_depend(gb_sim *sim, const double *y, const double *share, int settles);

/* After gb_find_shares at the front: whether a friction whose slip has just begun would slip back by the mean; it was
 * told to slip by the sides below. */
int gb_slips_turn(gb_sim *sim, const double *share);

#endif
