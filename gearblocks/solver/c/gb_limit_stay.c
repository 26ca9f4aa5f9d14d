#include "gb_limit_stay.h"
#include "gb_modes.h"
#include "gb_rates.h"
#include "gb_tolerance.h"
#include "gb_vector.h"

static const double SAME = 1e-12;  /* of the terms of a difference: what is left of it is nothing */
static const double UNTOLD = 1e-3; /* of the tolerance: how far two motions may come apart and be taken for one */

/* The rates in the present modes and in those in sliding.mode are the same at the end of the step, over a time h, as
 * far as the tolerance of a run can tell. */
static int moves_alike(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const gb_lanes *at = &sim->lanes;
    const int lane = sim->method->stages;
    double *here = sim->sliding.rates, *there = here + model->n_total, sum = 0.0;
    model->rhs(sim->par, sim->mode, at->time_terms + lane, sim->z, here);
    model->rhs(sim->par, sim->sliding.mode, gb_terms_above(sim, at, lane), sim->z, there);
    for (int j = 0; j < model->n; j++) {
        const double weight = sim->control.error_weight[j], apart = fabs(here[j] - there[j]);
        sum += weight > 0.0 ? apart * h * weight : apart > SAME * (fabs(here[j]) + fabs(there[j]));
    }
    return sum <= UNTOLD;
}

/* No other switch differs between the present modes and those in sliding.mode, there. */
static int others_agree(gb_sim *sim, int i) {
    const gb_model *model = sim->model;
    const gb_lanes *at = &sim->lanes;
    const int n = model->n_event_functions, lane = sim->method->stages;
    double *here = sim->sliding.functions, *there = here + n;
    model->event_functions(sim->par, sim->mode, at->time_terms + lane, sim->z, here);
    model->event_functions(sim->par, sim->sliding.mode, gb_terms_above(sim, at, lane), sim->z, there);
    for (int other = 0; other < n; other++) {
        const double limit = sim->events.hi[other] + SAME * fabs(there[other]);
        const int opens = sim->events.role[other] == GB_CONSTRAINED && here[other] <= limit && there[other] > limit;
        if (other != i &&
            (opens || model->mode_at(sim->par, other, here[other]) != model->mode_at(sim->par, other, there[other]))) {
            return 0;
        }
    }
    return 1;
}

double gb_swings_idly(gb_sim *sim, int i, double far) {
    const double *time_terms = sim->lanes.time_terms + sim->method->stages, h = sim->head->front.h;
    const double since = sim->head->front.t0 - sim->events.flip_time[i];
    if (sim->events.role[i] != GB_ORDINARY || sim->head->events.n_sliding > 0 || !(since <= h)) {
        return 0.0;
    }
    sim->model->event_functions(sim->par, sim->mode, time_terms, sim->z, sim->events.s);
    const double idle = UNTOLD * gb_tolerance_at(sim, i, time_terms, sim->z);
    memcpy(sim->sliding.mode, sim->mode, sizeof(double) * sim->unlocated.n_carried);
    sim->sliding.mode[i] = gb_far_side(sim, i, sim->events.side[i]);
    return far <= idle && moves_alike(sim, h) && others_agree(sim, i) ? idle : 0.0;
}
