#include "gb_limit_stay.h"
#include "gb_evaluate.h"
#include "gb_modes.h"
#include "gb_rates.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

static const double SAME = 1e-12;  /* of the terms of a difference: what is left of it is nothing */
static const double UNTOLD = 1e-3; /* of the tolerance: how far two motions may come apart and be taken for one */

/* The rates in the present modes and in those in sliding.mode are the same over a time h, as far as the tolerance of a
 * run can tell. */
static int moves_alike(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    double *here = sim->sliding.rates, *there = here + model->n_total, sum = 0.0;
    model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->y, here);
    model->rhs(sim->par, sim->sliding.mode, gb_terms_above(sim, &sim->instant, 0), sim->y, there);
    for (int j = 0; j < model->n; j++) {
        const double weight = sim->control.error_weight[j], apart = fabs(here[j] - there[j]);
        sum += weight > 0.0 ? apart * h * weight : apart > SAME * (fabs(here[j]) + fabs(there[j]));
    }
    return sum <= UNTOLD;
}

/* No other switch differs between the present modes and those in sliding.mode. */
static int others_agree(gb_sim *sim, int i) {
    const gb_model *model = sim->model;
    const int n = model->n_event_functions;
    double *here = sim->sliding.functions, *there = here + n;
    model->event_functions(sim->par, sim->mode, sim->instant.time_terms, sim->y, here);
    model->event_functions(sim->par, sim->sliding.mode, gb_terms_above(sim, &sim->instant, 0), sim->y, there);
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

int gb_stay_on_limit(gb_sim *sim, int i) {
    const double h = ldexp(gb_rounding(sim->head->front.t1, sim->head->front.h), 2 * (int)sim->events.flips[i]);
    if (sim->events.role[i] != GB_ORDINARY || i >= sim->model->n_event_functions || !sim->head->options.locate ||
        sim->head->events.n_sliding > 0 || gb_event_functions_now(sim) != GB_DONE ||
        gb_time_terms_at(sim, sim->head->front.t1) != GB_DONE) {
        return 0;
    }
    gb_mode_limits(sim);
    const double s = sim->events.s[i];
    const double side = fabs(s - sim->events.lo[i]) < fabs(s - sim->events.hi[i]) ? -1.0 : 1.0;
    memcpy(sim->sliding.mode, sim->mode, sizeof(double) * sim->unlocated.n_carried);
    sim->sliding.mode[i] = gb_far_side(sim, i, side);
    if (!moves_alike(sim, h) || !others_agree(sim, i)) {
        return 0;
    }
    gb_hold_limit(sim, i, side, sim->head->front.t1 + h);
    gb_mode_limits(sim);
    sim->events.armed[i] = sim->events.pending[i] = 0.0;
    return 1;
}
