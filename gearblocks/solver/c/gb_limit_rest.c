#include "gb_limit_rest.h"
#include "gb_constraint_state.h"
#include "gb_evaluate.h"
#include "gb_limit_bend.h"
#include "gb_modes.h"
#include "gb_rates.h"
#include "gb_report.h"
#include "gb_rest_share.h"
#include "gb_time_terms.h"
#include "gb_tolerance.h"
#include "gb_vector.h"

static const double UNTOLD = 1e-3;                 /* of the tolerance: the speeds of swings that are taken for none */
static const double MOMENT = 1e-3, NOTHING = 1e-9; /* how long coordinates follow test speeds; of their way */
/* Swings that are taken for none, in parts of the tolerance and in roundings of the coordinates: ever shorter ones, and
 * those that rounding keeps up. */
static const double NARROW[2] = {1e-4, 1e-1}, ROUNDINGS[2] = {4096.0, 262144.0};
static const double MOVED = 5e-3;   /* of the tolerance: so far a limit goes before it is left */
static const double AS_LONG = 50.0; /* swings: a step whose differences tell over one of them */
static const double STANDS = 0.1;   /* of the speed of swings: that of a limit that stands */
static const double SHORT = 1e-3;   /* of the largest step: flips that are looked at */

/* What it slides by is nothing in each of its speeds. */
static int hardly_slides(gb_sim *sim, int c) {
    const gb_model *model = sim->model;
    const int first = model->n - model->n_speeds;
    double *row = sim->sliding.rates, told = 0.0;
    model->constraint_row(sim->par, sim->mode, sim->instant.time_terms, sim->y, c, 0, row);
    for (int j = 0; j < model->n_speeds; j++) {
        const double weight = sim->control.error_weight[first + j];
        told += row[j] != 0.0 ? (weight > 0.0 ? fabs(row[j]) / weight : 0.0) : 0.0;
    }
    return fabs(sim->constraints.slip[c]) <= UNTOLD * told;
}

/* The modes with constraint c stuck, and its active set, in a place that the next call overwrites. */
static const double *modes_if_stuck(gb_sim *sim, int c) {
    const gb_constraint *of = &sim->model->constraints[c];
    memcpy(sim->sliding.mode, sim->mode, sizeof(double) * sim->unlocated.n_carried);
    sim->sliding.mode[of->active] = 1.0;
    sim->sliding.mode[of->slip] = 0.0;
    return gb_modes_with_active_set(sim, sim->sliding.mode, sim->instant.time_terms, sim->y);
}

/* How far event function i moves while the coordinates follow the speeds in y for a moment. */
static double way_of(gb_sim *sim, int i, double *y) {
    const gb_model *model = sim->model;
    double *rate = sim->sliding.rates, *value = sim->sliding.functions;
    model->rhs(sim->par, sim->mode, sim->instant.time_terms, y, rate);
    memcpy(y + model->n - model->n_speeds, sim->y + model->n - model->n_speeds,
           sizeof(double) * (size_t)model->n_speeds);
    for (int j = 0; j < model->n - model->n_speeds; j++) {
        y[j] += MOMENT * rate[j];
    }
    model->event_functions(sim->par, sim->mode, sim->instant.time_terms, y, value);
    return fabs(value[i] - sim->events.s[i]);
}

/* No motion in which constraint c is stuck moves event function i: else what is stuck would leave its limit together.
 * By speeds that know nothing of each other. */
static int holds_limit(gb_sim *sim, int i, int c) {
    const gb_model *model = sim->model;
    double *y = sim->sliding.state, way[2];
    for (int stuck = 0; stuck < 2; stuck++) {
        memcpy(y, sim->y, sizeof(double) * (size_t)model->n_padded);
        for (int j = 0; j < model->n_speeds; j++) {
            y[model->n - model->n_speeds + j] = 1.0 + fmod((j + 1) * 0.6180339887498949, 1.0);
        }
        model->event_functions(sim->par, sim->mode, sim->instant.time_terms, y, sim->sliding.functions);
        if (sim->sliding.functions[i] != sim->events.s[i]) {
            return 0; /* it reads speeds themselves */
        }
        if (stuck) {
            model->project_velocities(sim->par, modes_if_stuck(sim, c), sim->instant.time_terms, y);
        }
        way[stuck] = way_of(sim, i, y);
    }
    return way[0] > 0.0 && way[1] <= NOTHING * way[0];
}

/* What its slip has moved since the last flip is nothing in each coordinate, or a few roundings. */
static int hardly_swings(gb_sim *sim, int c, double since, double part, double roundings) {
    const gb_model *model = sim->model;
    double *now = sim->sliding.rates, *stuck = now + model->n_total, *y = sim->sliding.state;
    if (!(since <= SHORT * sim->head->control.h_largest)) {
        return 0;
    }
    const double *terms = sim->instant.time_terms;
    memcpy(y, sim->y, sizeof(double) * (size_t)model->n_padded);
    model->project_velocities(sim->par, modes_if_stuck(sim, c), terms, y);
    model->rhs(sim->par, sim->mode, terms, sim->y, now);
    model->rhs(sim->par, sim->mode, terms, y, stuck);
    for (int j = 0; j < model->n - model->n_speeds; j++) {
        const double width = since * fabs(now[j] - stuck[j]), weight = sim->control.error_weight[j];
        const int told = !(weight > 0.0) || width * weight > part;
        if (told && width > roundings * DBL_EPSILON * fabs(sim->y[j])) {
            return 0;
        }
    }
    return 1;
}

/* Constraint c, stuck, holds some mean of what is asked of it before and now; and neither of them, as they drive it to
 * either side, now against the direction of its slip (0: it is known that every mode drives it back). */
static int holds_between(const gb_sim *sim, int c, double direction, const gb_held_force in[2]) {
    double before[2], now[2];
    gb_held_range(sim, c, in, before);
    gb_held_range(sim, c, in + 1, now);
    const double share = gb_rest_share(sim, c, in);
    const int up = in[0].force < before[0] && in[1].force > now[1],
              down = in[0].force > before[1] && in[1].force < now[0];
    return (direction == 0.0 || (direction > 0.0 ? up : down)) && share >= 0.0 && share <= 1.0;
}

/* The force of constraint c, as if stuck, in the modes at hand. */
static gb_held_force force_if_stuck(gb_sim *sim, double *mode, const double *terms, int c) {
    const gb_constraint *of = &sim->model->constraints[c];
    const double active = mode[of->active], direction = mode[of->slip];
    mode[of->active] = 1.0;
    mode[of->slip] = 0.0;
    const gb_held_force in =
        gb_held_force_in(sim, gb_modes_with_active_set(sim, mode, terms, sim->y), terms, sim->y, c);
    mode[of->active] = active;
    mode[of->slip] = direction;
    return in;
}

/* Whether constraint c, which slips in a direction (0: any), and the switch i, which was in the mode `before`, rest
 * together. */
static int rest_together(gb_sim *sim, int i, double before, int c, double direction) {
    gb_held_force in[2];
    double *other = sim->sliding.mode;
    in[1] = force_if_stuck(sim, sim->mode, sim->instant.time_terms, c);
    memcpy(other, sim->mode, sizeof(double) * sim->unlocated.n_carried);
    other[i] = before;
    in[0] = force_if_stuck(sim, other, gb_terms_above(sim, &sim->instant, 0), c);
    return holds_between(sim, c, direction, in);
}

/* The limit of switch i goes by itself, as it reads time, as fast as the swings about it that took so long. */
static int goes_by_itself(gb_sim *sim, int i, double since) {
    const gb_model *model = sim->model;
    double *rates = sim->sliding.rates, way[3], swings[3];
    const double h = since > 0.0 ? AS_LONG * since : sim->head->control.h_next;
    memset(rates, 0, sizeof(double) * (size_t)model->n_total);
    gb_limit_bend(sim, i, rates, &sim->instant, 0, sim->y, h, 0.0, way);
    if (way[0] == 0.0) {
        return 0;
    }
    model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->y, rates);
    gb_limit_bend(sim, i, rates, &sim->instant, 0, sim->y, h, 0.0, swings);
    return !(fabs(way[0]) <= STANDS * fabs(swings[0]));
}

/* A friction, or the losses of a gear. */
static int can_hold(const gb_model *model, int c) {
    return model->constraints[c].kind == GB_FRICTION || model->constraints[c].kind == GB_LOSS;
}

/* Both are at rest from here on. */
static int rest(gb_sim *sim, int i, double before, int c) {
    struct gb_event_state *events = &sim->head->events;
    const gb_constraint *of = &sim->model->constraints[c];
    const double below = gb_min(before, sim->mode[i]);
    gb_log(sim, i, 0, sim->mode[i], below + 0.5);
    gb_log(sim, of->slip, 0, sim->mode[of->slip], 0.0);
    gb_set_mode(sim, i, below, 0);
    gb_set_mode(sim, of->active, 1.0, 0);
    gb_set_mode(sim, of->slip, 0.0, 0);
    events->resting[events->n_sliding] = c;
    events->rested_at[events->n_sliding] = sim->events.s[i];
    events->reach[events->n_sliding] = MOVED * gb_tolerance_of(sim, i);
    events->sliding[events->n_sliding++] = i;
    gb_factor_active_set(sim, sim->mode, sim->instant.time_terms, sim->y);
    gb_project_velocities(sim, sim->instant.time_terms);
    sim->events.armed[i] = sim->events.pending[i] = sim->events.flips[i] = 0.0;
    sim->events.armed[of->slip] = sim->events.armed[of->active] = 0.0;
    gb_rehash(sim);
    gb_mode_limits(sim);
    return 1;
}

int gb_come_to_rest(gb_sim *sim, int i, double since, int settled) {
    const gb_model *model = sim->model;
    const gb_head *head = sim->head;
    if (model->n_constraints == 0 || sim->events.role[i] != GB_ORDINARY || i >= model->n_event_functions ||
        head->events.n_sliding >= GB_SLIDING || gb_slides(sim, i) || !head->options.locate ||
        gb_event_functions_now(sim) != GB_DONE || gb_time_terms_at(sim, head->front.t1) != GB_DONE) {
        return 0;
    }
    gb_mode_limits(sim);
    const double side =
        fabs(sim->events.s[i] - sim->events.lo[i]) < fabs(sim->events.s[i] - sim->events.hi[i]) ? -1.0 : 1.0;
    const double before = gb_far_side(sim, i, side);
    if (fabs(sim->mode[i] - before) != 1.0) {
        return 0;
    }
    const double roundings = ldexp(ROUNDINGS[settled], (int)sim->events.flips[i] - 1); /* see gb_limit_rounding */
    gb_slips_now(sim);
    for (int c = 0; c < model->n_constraints; c++) {
        const double direction = since > 0.0 ? sim->mode[model->constraints[c].slip] : 0.0;
        if (can_hold(model, c) && !gb_is_active(sim, c) && (since == 0.0 || direction != 0.0) &&
            (hardly_slides(sim, c) || hardly_swings(sim, c, since, NARROW[settled], roundings)) &&
            rest_together(sim, i, before, c, direction) && holds_limit(sim, i, c) && !goes_by_itself(sim, i, since)) {
            return rest(sim, i, before, c);
        }
    }
    return 0;
}
