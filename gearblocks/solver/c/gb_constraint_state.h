/* Switched constraints at the front: which are active, their slips G v, the projection of the speeds onto G v = 0, and
 * the complementarity problem of some of them (gb_lcp.h) with the Delassus matrix W.
 * Knows nothing of when modes change. */
#ifndef GB_CONSTRAINT_STATE_H
#define GB_CONSTRAINT_STATE_H

#include "gb_internal.h"

/* Forces (or impulses) x of `count` constraints, numbered by index[], with lo <= x <= hi and  W x + right complementary
 * to the bounds; W from `delassus`. */
int gb_solve_problem(gb_sim *sim, int count);

/* Of constraint i: it is active; it is a stop; no force takes it out of its bounds. */
int gb_is_stuck(const gb_sim *sim, int i);

int gb_is_stop(const gb_sim *sim, int i);

int gb_is_unlimited(const gb_sim *sim, int i);

/* The gap of a stop is closed: it has just been met, or has no width. */
int gb_touches(const gb_sim *sim, int i);

/* It can transmit a force at all. */
int gb_does_rub(const gb_sim *sim, int i);

/* Sums of the sizes of the rows' numbers, by which the rounding of slips is judged. */
void gb_size_locks(gb_sim *sim);

/* The memory behind the modes. */
void gb_remember(gb_sim *sim, double *mode, const double *tau, const double *y);

/* A row's modes with their memory, in a place that the next call overwrites. */
const double *gb_full_modes(gb_sim *sim, const double *mode, const double *tau, const double *y);

/* Speeds at which nothing slips that sticks; 1: they changed by more than rounding. */
int gb_project(gb_sim *sim, const double *tau);

/* Slips at the front, and what is no more than rounding of each. */
void gb_slips_now(gb_sim *sim);

/* Locks that no force can break must not be asked for slips that contradict each other (two of them between a shaft of
 * prescribed speed and the ground): after the forces x, or impulses, nothing may be left of b where x is inside its
 * limits. */
int gb_refuse_tie_up(gb_sim *sim, int count);

#endif
