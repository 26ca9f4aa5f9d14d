/* The rates in the present modes. Where switches slide along their limits (gb_sliding.h) they are a mean of those on
 * both sides:
 *     y' = f_a + sum_j share_j (f_j - f_a),   with shares so that every s_j' = 0
 * f_a: the rates with every such switch below its limit, f_j: with the j-th above. A switch that slides keeps the mode
 * below in `mode`; recorded rows hold that mode plus its share.
 * Where a friction or a lossy gear rests on such a limit (gb_limit_rest.h) the rates are alike on both sides, as it
 * holds what either asks of it; the share is one of those by which it holds the mean (gb_rest_share.h).
 * Knows nothing of when a switch begins to slide, of methods and of steps. */
#ifndef GB_RATES_H
#define GB_RATES_H

#include "gb_internal.h"

void gb_sliding_rates(gb_sim *sim, int full, const gb_lanes *at, int lane, const double *y, double *dy);

/* The rates (with `full` those of the quadratures too) in the present modes at lane `lane` of `at`, where nothing
 * slides. */
static inline void gb_mode_rates(gb_sim *sim, int full, const gb_lanes *at, int lane, const double *y, double *dy) {
    (full ? sim->model->rhs_full : sim->model->rhs)(sim->par, sim->mode, at->time_terms + lane, y, dy);
}

/* The same, whatever slides. */
static inline void gb_rates(gb_sim *sim, int full, const gb_lanes *at, int lane, const double *y, double *dy) {
    if (sim->head->events.n_sliding > 0) {
        gb_sliding_rates(sim, full, at, lane, y, dy);
    } else {
        gb_mode_rates(sim, full, at, lane, y, dy);
    }
}

/* Constraint c, which one side of what slides would not hold, is judged by the mean of all. */
static inline int gb_holds_by_mean(const gb_sim *sim, int c) {
    return c < 64 && (sim->head->events.by_mean >> c & 1) != 0;
}

/* Whether switch i slides. */
int gb_slides(const gb_sim *sim, int i);

/* Whether constraint c, a friction or a lossy gear, rests on the limit of one that slides. */
static inline int gb_rests(const gb_sim *sim, int c) {
    int j = 0;
    while (j < sim->head->events.n_sliding && sim->head->events.resting[j] != c) {
        j++;
    }
    return j < sim->head->events.n_sliding;
}

/* How fast the event functions of those that slide change along rates f, by differences at so many times f, and at so
 * many s later. */
void gb_speeds_along(gb_sim *sim, const double *f, const gb_lanes *at, int lane, const double *y, double apart,
                     double later, double *speed);

/* The same of what the accelerations among the rates f make of their rates, at rest on their limits; they read
 * coordinates alone. */
void gb_accelerations_along(gb_sim *sim, const double *f, const gb_lanes *at, int lane, const double *y, double *speed);

/* The shares for which no limit is left. 0: there are none; 1: a limit is no place to stay; 2: they all attract. */
int gb_find_shares(gb_sim *sim, int full, const gb_lanes *at, int lane, const double *y, double *share);

/* The present modes with those that slide above their limits of which `which` has the bit, into sliding.mode. */
void gb_set_above(gb_sim *sim, int which);

/* Time terms of one lane of `at` for the modes in sliding.mode. */
const double *gb_terms_above(gb_sim *sim, const gb_lanes *at, int lane);

/* Adds the shares at lane `lane` of `at` to the modes of those that slide. */
void gb_mode_with_shares(gb_sim *sim, const gb_lanes *at, int lane, const double *y, double *mode);

#endif
