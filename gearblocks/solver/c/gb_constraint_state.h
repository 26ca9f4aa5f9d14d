/* Switched constraints at the front: which are active, their slips G v, the projection of the speeds onto G v = 0, and
 * the complementarity problem of some of them (gb_lcp.h) with the Delassus matrix W.
 * Knows nothing of when modes change. */
#ifndef GB_CONSTRAINT_STATE_H
#define GB_CONSTRAINT_STATE_H

#include "gb_constraint_rows.h"
#include "gb_internal.h"

/* W as it was made last. */
gb_delassus gb_delassus_of(const gb_sim *sim);

/* Forces (or impulses) x of the constraints with in[i] (0 for all others) with lo <= x <= hi and  W x + right
 * complementary to the bounds. coupled: bounds grow with other forces. */
int gb_solve_problem(gb_sim *sim, int coupled);

/* Of constraint i: it is active; it is a stop; its force has no bounds. */
int gb_is_active(const gb_sim *sim, int i);
int gb_is_stop(const gb_sim *sim, int i);
int gb_is_unbounded(const gb_sim *sim, int i);

/* A one-way clutch does not turn backward: a slip that way, behind all impacts, is what they rounded. */
int gb_is_blocked(const gb_sim *sim, int i, double direction);

/* Some constraint is active. */
static inline int gb_some_active(const gb_sim *sim) {
    return sim->model->n_constraints > 0 && sim->mode[sim->model->n_switches] > 0.0;
}

/* The gap of a stop is closed: it has just been met, or has no width. */
int gb_touches(const gb_sim *sim, int i);

/* What moves at an open stop has gone beyond it in a look ahead, by more than `unit` of the sizes of the gap: so far
 * ahead the modes of now tell nothing. */
int gb_passes_a_stop(const gb_sim *sim, double unit);

/* It can transmit a force at all. */
int gb_is_engaged(const gb_sim *sim, int i);

/* Bounds of the constraint forces in the present modes; none of a friction that rests on a limit (gb_rates.h). */
void gb_read_bounds(gb_sim *sim, const double *y);

/* Sums of the sizes of the coefficients of G, by which the rounding of slips is judged. */
void gb_size_rows(gb_sim *sim);

/* The active set behind the modes, with its factors. */
void gb_factor_active_set(gb_sim *sim, double *mode, const double *time_terms, const double *y);

/* The modes of a recorded row with their active set, in a place that the next call overwrites. */
const double *gb_modes_with_active_set(gb_sim *sim, const double *mode, const double *time_terms, const double *y);

/* Velocity projection: removes the slips of active constraints; 1: speeds changed by more than rounding. */
int gb_project_velocities(gb_sim *sim, const double *time_terms);

/* The active set is like ties whose gains are powers of two: steps leave its slips at zero to the last bit. */
int gb_slips_are_exact(const gb_sim *sim);

/* The projection behind a step, where there may be slips. */
static inline int gb_slips_remain(gb_sim *sim, const double *time_terms) {
    return sim->model->n_constraints > 0 && !gb_slips_are_exact(sim) && gb_project_velocities(sim, time_terms);
}

/* The largest speed in y. */
double gb_largest_speed(const gb_sim *sim, const double *y);

/* Slips at the front, and what is no more than rounding of each. */
void gb_slips_now(gb_sim *sim);

/* Unbounded constraints must not be asked for slips that contradict each other (two of them between a shaft of
 * prescribed speed and the ground): after the forces x, or impulses, nothing may be left of the right side where x is
 * inside its bounds. noise: rounding of the rates (or speeds) that it is made of; less is nothing. */
int gb_refuse_contradiction(gb_sim *sim, double noise);

#endif
