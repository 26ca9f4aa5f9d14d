#include "gb_limit_bend.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

enum { POINTS = 4 };

/* Differences of fourth order: where, and the weights for the first and the second derivative. */
static const double point[POINTS] = {-2.0, -1.0, 1.0, 2.0};
static const double first[POINTS] = {1.0 / 12.0, -8.0 / 12.0, 8.0 / 12.0, -1.0 / 12.0};
static const double second[POINTS] = {-1.0 / 12.0, 16.0 / 12.0, 16.0 / 12.0, -1.0 / 12.0};
static const double NEAR = 2e-2;     /* of a step: between points */
static const double TURN = 1e-2;     /* rad or m: and no farther */
static const double FIRST = 1e-3;    /* s */
static const double ADMITTED = 1e-2; /* of what is admitted: rounding of differences */
static const double ROUNDING = 16.0 * DBL_EPSILON;

/* The size of the terms of event function i: what the coordinates make of it. */
static double size_of_terms(gb_sim *sim, int i, double here, const double *time_terms, const double *y) {
    const gb_model *model = sim->model;
    double *state = sim->sliding.state, *s = sim->sliding.functions;
    memcpy(state, y, sizeof(double) * (size_t)model->n_padded);
    memset(state, 0, sizeof(double) * (size_t)(model->n - model->n_speeds));
    model->event_functions(sim->par, sim->mode, time_terms, state, s);
    return fabs(here) + fabs(s[i] - here);
}

/* The time between points. At the start nothing is known of a step. */
static double points_apart(double size, double h, double admitted) {
    h = h > 0.0 ? h : FIRST;
    const double least = sqrt(5.0 * DBL_EPSILON * size * h / (ADMITTED * admitted));
    return least < HUGE_VAL ? gb_max(NEAR * h, least) : NEAR * h;
}

static double fastest(const gb_model *model, const double *f) {
    double most = 0.0;
    for (int k = 0; k < model->n - model->n_speeds; k++) {
        most = gb_max(most, fabs(f[k]));
    }
    return most;
}

/* y with the coordinates moved along rates f, which change by c, for a time. */
static const double *moved(gb_sim *sim, const double *y, double time, const double *f, const double *c) {
    const gb_model *model = sim->model;
    double *state = sim->sliding.state;
    memcpy(state, y, sizeof(double) * (size_t)model->n_padded);
    for (int k = 0; k < model->n - model->n_speeds; k++) {
        state[k] += time * (f[k] + 0.5 * time * c[k]);
    }
    return state;
}

void gb_limit_bend(gb_sim *sim, int i, const double *f, const gb_lanes *at, int lane, const double *y, double h,
                   double admitted, double bend[3]) {
    const gb_model *model = sim->model;
    double *change = sim->sliding.rates + (size_t)(1 + GB_SLIDING) * (size_t)model->n_total;
    double *there = change + model->n_total, *s = sim->sliding.functions;
    gb_lanes *own = &sim->sliding.lanes;
    model->event_functions(sim->par, sim->mode, at->time_terms + lane, y, s);
    const double here = s[i], size = size_of_terms(sim, i, here, at->time_terms + lane, y);
    const double apart = gb_min(points_apart(size, h, admitted), TURN / gb_max(fastest(model, f), DBL_MIN));
    bend[0] = bend[1] = 0.0;
    bend[2] = here;
    for (int p = 0; p < POINTS; p++) {
        own->t[p] = at->t[lane] + point[p] * apart;
        for (int k = 0; k < model->n_inputs; k++) { /* of those that move they are overwritten */
            own->u[k * GB_LANES + p] = at->u[k * GB_LANES + lane];
        }
    }
    if (gb_time_terms(sim, POINTS, own) != GB_DONE) {
        return;
    }
    memset(change, 0, 2 * sizeof(double) * (size_t)model->n_total);
    for (int p = 0; p < POINTS; p++) {
        const double *state = moved(sim, y, point[p] * apart, f, there); /* there: still 0 */
        model->rhs(sim->par, sim->mode, own->time_terms + p, state, there);
        for (int k = 0; k < model->n - model->n_speeds; k++) {
            change[k] += first[p] / apart * (there[k] - f[k]);
        }
        memset(there, 0, sizeof(double) * (size_t)model->n_total);
    }
    for (int p = 0; p < POINTS; p++) {
        model->event_functions(sim->par, sim->mode, own->time_terms + p, moved(sim, y, point[p] * apart, f, change), s);
        bend[0] += first[p] / apart * (s[i] - here);
        bend[1] += second[p] / (apart * apart) * (s[i] - here);
    }
    bend[0] = fabs(bend[0]) * apart <= ROUNDING * size ? 0.0 : bend[0];
    bend[1] = fabs(bend[1]) * apart * apart <= 2.0 * ROUNDING * size ? 0.0 : bend[1];
}

int gb_limit_moves(gb_sim *sim, int j, const double *y, int speed) {
    const gb_model *model = sim->model;
    const struct gb_event_state *events = &sim->head->events;
    const int i = events->sliding[j];
    double *f = sim->sliding.rates, bend[3];
    if (events->resting[j] == -1 && !(speed && events->reach[j] > 0.0)) {
        return 0;
    }
    model->event_functions(sim->par, sim->mode, sim->instant.time_terms, y, sim->sliding.functions);
    const double way = sim->sliding.functions[i] - events->rested_at[j];
    if (fabs(way) > events->reach[j] || events->resting[j] != GB_HELD || !speed) {
        return (way > events->reach[j]) - (way < -events->reach[j]);
    }
    model->rhs(sim->par, sim->mode, sim->instant.time_terms, y, f);
    gb_limit_bend(sim, i, f, &sim->instant, 0, y, sim->head->control.h_next, events->admitted[j], bend);
    return (bend[0] > events->admitted[j]) - (bend[0] < -events->admitted[j]);
}
