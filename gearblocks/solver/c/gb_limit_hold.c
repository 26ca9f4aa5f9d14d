#include "gb_limit_hold.h"
#include "gb_constraint_state.h"
#include "gb_limit_bend.h"
#include "gb_rates.h"
#include "gb_tolerance.h"
#include "gb_turned_gears.h"
#include "gb_vector.h"

static const double UNTOLD = 1e-3; /* of the tolerance: the speed that is taken for none */
static const double NARROW = 1e-1; /* of the tolerance: swings that are taken for none */
static const double REACH = 10.0;  /* tolerances: how far one that is held may come from its limit */
static const double SHORT = 1e-3;  /* of the largest step: flips that are looked at */
static const double SAME = 1e-9;   /* of a speed: what differences leave of it */
static const double APART = 1e-4;  /* rad or m, of differences */

/* How fast the event function changes along rates f of the coordinates, and over time. room: rates. */
static double speed_along(gb_sim *sim, int i, const double *f, double *room, double since) {
    const gb_model *model = sim->model;
    double speed[GB_SLIDING], over_time[3], most = 0.0;
    memset(room, 0, sizeof(double) * (size_t)model->n_total);
    gb_limit_bend(sim, i, room, &sim->instant, 0, sim->y, since > 0.0 ? since : sim->head->control.h_next, 0.0,
                  over_time);
    for (int j = 0; j < model->n - model->n_speeds; j++) {
        room[j] = f[j];
        most = gb_max(most, fabs(f[j]));
    }
    gb_speeds_along(sim, room, &sim->instant, 0, sim->y, APART / gb_max(most, DBL_MIN), 0.0, speed);
    const double own = most > 0.0 ? speed[sim->head->events.n_sliding - 1] : 0.0, sum = over_time[0] + own;
    return fabs(sum) <= SAME * fabs(own) ? 0.0 : sum;
}

/* It reads speeds themselves: what they are without the motion. */
static int reads_speeds(gb_sim *sim, int i) {
    const gb_model *model = sim->model;
    double *y = sim->sliding.state, *s = sim->sliding.functions;
    model->event_functions(sim->par, sim->mode, sim->instant.time_terms, sim->y, s);
    const double here = s[i];
    memcpy(y, sim->y, sizeof(double) * (size_t)model->n_padded);
    for (int j = model->n - model->n_speeds; j < model->n; j++) {
        y[j] = 1.0 + fmod((j + 1) * 0.6180339887498949, 1.0);
    }
    model->event_functions(sim->par, sim->mode, sim->instant.time_terms, y, s);
    return s[i] != here;
}

void gb_admit(gb_sim *sim, int j) {
    const gb_model *model = sim->model;
    double *rate = sim->sliding.rates, sum = 0.0;
    for (int k = model->n - model->n_speeds; k < model->n; k++) {
        const double weight = sim->control.error_weight[k];
        double speed[GB_SLIDING];
        memset(rate, 0, sizeof(double) * (size_t)model->n_total);
        rate[k] = 1.0;
        if (weight > 0.0) {
            gb_accelerations_along(sim, rate, &sim->instant, 0, sim->y, speed);
            sum += fabs(speed[j]) / weight;
        }
    }
    sim->head->events.admitted[j] = sum;
    sim->head->events.reach[j] = REACH * gb_tolerance_of(sim, sim->head->events.sliding[j]);
}

/* Its swings end: so slow, as a part of what is admitted, or so low. */
static int ends(gb_sim *sim, int i, double speed, double since, double admitted) {
    const int narrow = since > 0.0 && since <= SHORT * sim->head->control.h_largest &&
                       since * fabs(speed) <= NARROW * gb_tolerance_of(sim, i);
    return narrow || fabs(speed) <= UNTOLD * admitted;
}

/* A friction slips by the swings: it takes a part of each, and they end where it sticks. rates: below and above; the
 * impulse of the jump that ends them is so many s of it. */
static int rubs_by_swings(gb_sim *sim, const double *below, const double *above, double impulse) {
    const gb_model *model = sim->model;
    double *one = sim->constraints.right, *other = sim->constraints.free_acceleration;
    if (model->n_constraints == 0) {
        return 0;
    }
    gb_slips_now(sim);
    model->slips(sim->par, sim->mode, sim->instant.time_terms, sim->y, below, one);
    model->slips(sim->par, sim->mode, sim->instant.time_terms, sim->y, above, other);
    for (int c = 0; c < model->n_constraints; c++) {
        const double slip = sim->constraints.slip[c];
        if (model->constraints[c].kind != GB_STOP && model->constraints[c].kind != GB_TIE && !gb_is_active(sim, c) &&
            sim->mode[model->constraints[c].slip] != 0.0 &&
            fabs(slip - impulse * (other[c] - one[c])) <= 0.5 * fabs(slip)) {
            return 1;
        }
    }
    return 0;
}

/* The jump of the rates ends the speed by so many s of it, and works meanwhile. */
static void end_by_impulse(gb_sim *sim, double impulse, double *below, double *above, double *change) {
    const gb_model *model = sim->model;
    const int first = model->n - model->n_speeds;
    for (int j = first; j < model->n; j++) {
        change[j] = impulse * (above[j] - below[j]);
        sim->y[j] -= 0.5 * change[j];
    }
    model->rhs_full(sim->par, sim->mode, sim->instant.time_terms, sim->y, below);
    model->rhs_full(sim->par, sim->sliding.mode, gb_terms_above(sim, &sim->instant, 0), sim->y, above);
    for (int j = first; j < model->n; j++) {
        sim->y[j] -= 0.5 * change[j];
    }
    for (int k = model->n_padded; k < model->n_total; k++) {
        sim->y[k] -= impulse * (above[k] - below[k]);
    }
}

int gb_hold_last(gb_sim *sim, double since) {
    const gb_model *model = sim->model;
    const struct gb_event_state *events = &sim->head->events;
    const int n = events->n_sliding, i = events->sliding[n - 1];
    double *below = sim->sliding.rates, *above = below + model->n_total, *room = above + model->n_total;
    double speed[2][GB_SLIDING];
    if (reads_speeds(sim, i) || !gb_turn_gears(sim)) {
        return 0;
    }
    model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->y, below);
    const double rate = speed_along(sim, i, below, room, since);
    gb_admit(sim, n - 1);
    if (!ends(sim, i, rate, since, events->admitted[n - 1])) {
        return 0;
    }
    model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->y, below);
    gb_set_above(sim, 1 << (n - 1));
    model->rhs(sim->par, sim->sliding.mode, gb_terms_above(sim, &sim->instant, 0), sim->y, above);
    gb_accelerations_along(sim, below, &sim->instant, 0, sim->y, speed[0]);
    gb_accelerations_along(sim, above, &sim->instant, 0, sim->y, speed[1]);
    const double jump = speed[1][n - 1] - speed[0][n - 1];
    const double longest = SHORT * sim->head->control.h_largest; /* of swings: what drives back ends them sooner */
    if (!(jump < 0.0) || fabs(rate) > -jump * longest || rubs_by_swings(sim, below, above, rate / jump)) {
        return 0;
    }
    end_by_impulse(sim, rate / jump, below, above, room);
    return 1;
}
