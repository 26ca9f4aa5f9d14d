#include "gb_rates.h"
#include "gb_limit_bend.h"
#include "gb_rest_share.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

enum { POINTS = 4 };

/* A difference of fourth order. */
static const double point[POINTS] = {-2.0, -1.0, 1.0, 2.0};
static const double weight[POINTS] = {1.0 / 12.0, -8.0 / 12.0, 8.0 / 12.0, -1.0 / 12.0};
static const double NEAR = 1e-3;  /* its points, in steps: it tells 1e-12 of what a step tells */
static const double APART = 1e-4; /* rad or m: where the direction alone counts */
static const double ROUNDING = 64.0 * DBL_EPSILON;
static const double BACK = 0.1;   /* part of a step: so soon what errors have left of a rate that is held goes back */
static const double TOLD = 1e-4;  /* of its reach: a way that is an error */
static const double LEAST = 1e-9; /* share in a recorded mode, that shows as one */

int gb_slides(const gb_sim *sim, int i) {
    for (int j = 0; j < sim->head->events.n_sliding; j++) {
        if (sim->head->events.sliding[j] == i) {
            return 1;
        }
    }
    return 0;
}

void gb_set_above(gb_sim *sim, int which) {
    memcpy(sim->sliding.mode, sim->mode, sizeof(double) * sim->unlocated.n_carried);
    for (int j = 0; j < sim->head->events.n_sliding; j++) {
        sim->sliding.mode[sim->head->events.sliding[j]] += which >> j & 1;
    }
    for (int c = 0; which != 0 && sim->head->events.turned >> c != 0; c++) {
        const int sign = sim->model->constraints[c].slip;
        sim->sliding.mode[sign] *= sim->head->events.turned >> c & 1 ? -1.0 : 1.0;
    }
}

const double *gb_terms_above(gb_sim *sim, const gb_lanes *at, int lane) {
    const gb_model *model = sim->model;
    gb_lanes *own = &sim->sliding.lanes;
    if (model->n_time_terms == 0) {
        return own->time_terms;
    }
    for (int l = 0; l < GB_LANES; l++) {
        own->t[l] = at->t[lane];
        for (int i = 0; i < model->n_inputs; i++) {
            own->u[i * GB_LANES + l] = at->u[i * GB_LANES + lane];
        }
    }
    model->time_terms(sim->par, sim->sliding.mode, 1, own->t, own->u, own->time_terms);
    return own->time_terms;
}

/* The rates below all limits and above each. */
static void rates_beside(gb_sim *sim, int full, const gb_lanes *at, int lane, const double *y) {
    const gb_model *model = sim->model;
    double *rates = sim->sliding.rates;
    (full ? model->rhs_full : model->rhs)(sim->par, sim->mode, at->time_terms + lane, y, rates);
    for (int j = 0; j < sim->head->events.n_sliding; j++) {
        gb_set_above(sim, 1 << j);
        const double *terms = gb_terms_above(sim, at, lane);
        rates += model->n_total;
        (full ? model->rhs_full : model->rhs)(sim->par, sim->sliding.mode, terms, y, rates);
        sim->head->counts.rhs_calls++;
    }
}

void gb_speeds_along(gb_sim *sim, const double *f, const gb_lanes *at, int lane, const double *y, double apart,
                     double later, double *speed) {
    const gb_model *model = sim->model;
    const int n = sim->head->events.n_sliding, *sliding = sim->head->events.sliding;
    double *s = sim->sliding.functions, *state = sim->sliding.state;
    gb_lanes *own = &sim->sliding.lanes;
    int general = 0;
    if (model->n_affine > 0) {
        model->directions(sim->par, f, s);
    }
    for (int j = 0; j < n; j++) {
        general |= sliding[j] >= model->n_affine;
        speed[j] = sliding[j] < model->n_affine ? s[sliding[j]] : 0.0;
    }
    for (int p = 0; p < POINTS && general; p++) {
        own->t[p] = at->t[lane] + point[p] * later;
        for (int i = 0; i < model->n_inputs; i++) { /* of those that move they are overwritten */
            own->u[i * GB_LANES + p] = at->u[i * GB_LANES + lane];
        }
    }
    if (!general || gb_time_terms(sim, POINTS, own) != GB_DONE) {
        return;
    }
    for (int p = 0; p < POINTS; p++) {
        for (int i = 0; i < model->n_padded; i++) {
            state[i] = y[i] + (i < model->n ? point[p] * apart * f[i] : 0.0);
        }
        model->event_functions(sim->par, sim->mode, own->time_terms + p, state, s);
        for (int j = 0; j < n; j++) {
            speed[j] += sliding[j] < model->n_affine ? 0.0 : weight[p] / apart * s[sliding[j]];
        }
    }
}

void gb_accelerations_along(gb_sim *sim, const double *f, const gb_lanes *at, int lane, const double *y,
                            double *speed) {
    const gb_model *model = sim->model;
    const int first = model->n - model->n_speeds;
    double *state = sim->sliding.state, most = 0.0;
    double *pushed = sim->sliding.rates + (size_t)(1 + GB_SLIDING) * (size_t)model->n_total;
    double *still = pushed + model->n_total;
    for (int moves = 0; moves < 2; moves++) {
        memcpy(state, y, sizeof(double) * (size_t)model->n_padded);
        for (int i = first; i < model->n; i++) {
            state[i] = moves ? f[i] : 0.0;
        }
        model->rhs(sim->par, sim->mode, at->time_terms + lane, state, moves ? pushed : still);
    }
    for (int i = 0; i < model->n; i++) {
        pushed[i] = i < first ? pushed[i] - still[i] : 0.0;
        most = gb_max(most, fabs(pushed[i]));
    }
    gb_speeds_along(sim, pushed, at, lane, y, most > 0.0 ? APART / most : 1.0, 0.0, speed);
}

static double step_ahead(const gb_sim *sim) {
    const double h = gb_min(sim->head->control.h_next, sim->head->options.max_step);
    return h > 0.0 ? h : NEAR;
}

/* Of one that is held: what its rate changes by beside the accelerations, and what brings it back from errors. */
static double bend_of_held(gb_sim *sim, int j, const gb_lanes *at, int lane, const double *y) {
    const struct gb_event_state *events = &sim->head->events;
    const double h = step_ahead(sim), back = BACK / h;
    double bend[3];
    gb_limit_bend(sim, events->sliding[j], sim->sliding.rates, at, lane, y, h, events->admitted[j], bend);
    const double way = bend[2] - events->rested_at[j];
    return bend[1] + back * (2.0 * bend[0] + (fabs(way) > TOLD * events->reach[j] ? back * way : 0.0));
}

/* How fast the event functions of those that slide change along rates f; of those that are held, how fast their rates
 * do. */
static void speeds_along(gb_sim *sim, const double *f, const gb_lanes *at, int lane, const double *y, double *speed) {
    const double step = step_ahead(sim);
    const int n = sim->head->events.n_sliding, *resting = sim->head->events.resting;
    double second[GB_SLIDING];
    int held = 0;
    for (int j = 0; j < n; j++) {
        held |= resting[j] == GB_HELD;
    }
    gb_speeds_along(sim, f, at, lane, y, NEAR * step, NEAR * step, speed);
    if (held) {
        gb_accelerations_along(sim, f, at, lane, y, second);
    }
    for (int j = 0; j < n && held; j++) {
        speed[j] = resting[j] == GB_HELD ? second[j] : speed[j];
    }
}

/* Solves a x = b for n unknowns; 0: it has no single answer. */
static int solve(int n, double a[GB_SLIDING][GB_SLIDING], double *b) {
    for (int c = 0; c < n; c++) {
        int best = c;
        for (int r = c + 1; r < n; r++) {
            best = fabs(a[r][c]) > fabs(a[best][c]) ? r : best;
        }
        if (!(fabs(a[best][c]) > 0.0)) {
            return 0;
        }
        for (int k = 0; k < n; k++) {
            const double other = a[c][k];
            a[c][k] = a[best][k];
            a[best][k] = other;
        }
        const double other = b[c];
        b[c] = b[best];
        b[best] = other;
        for (int r = 0; r < n; r++) {
            const double factor = r == c ? 0.0 : a[r][c] / a[c][c];
            for (int k = c; k < n && r != c; k++) {
                a[r][k] -= factor * a[c][k];
            }
            b[r] -= factor * b[c];
        }
    }
    for (int c = 0; c < n; c++) {
        b[c] /= a[c][c];
    }
    return 1;
}

/* Of those that rest, by the forces of what rests on them; of the others at their shares. */
static void resting_shares(gb_sim *sim, const gb_lanes *at, int lane, const double *y, double *share) {
    const int *resting = sim->head->events.resting;
    for (int j = 0; j < sim->head->events.n_sliding; j++) {
        if (resting[j] < 0) {
            continue;
        }
        gb_held_force in[2];
        in[0] = gb_held_force_in(sim, sim->mode, at->time_terms + lane, y, resting[j]);
        gb_set_above(sim, 1 << j);
        in[1] = gb_held_force_in(sim, sim->sliding.mode, gb_terms_above(sim, at, lane), y, resting[j]);
        share[j] = gb_rest_share(sim, resting[j], in);
    }
}

int gb_find_shares(gb_sim *sim, int full, const gb_lanes *at, int lane, const double *y, double *share) {
    const int n = sim->head->events.n_sliding;
    double a[GB_SLIDING][GB_SLIDING], below[GB_SLIDING], above[GB_SLIDING], moving[GB_SLIDING];
    int attracts = 1, which[GB_SLIDING], n_moving = 0;
    rates_beside(sim, full, at, lane, y);
    for (int j = 0; j < n; j++) {
        if (sim->head->events.resting[j] < 0) {
            which[n_moving++] = j;
        }
    }
    if (n_moving > 0) {
        speeds_along(sim, sim->sliding.rates, at, lane, y, below);
    }
    for (int j = 0; j < n_moving; j++) {
        speeds_along(sim, sim->sliding.rates + (size_t)(1 + which[j]) * (size_t)sim->model->n_total, at, lane, y,
                     above);
        for (int i = 0; i < n_moving; i++) {
            a[i][j] = above[which[i]] - below[which[i]];
        }
        attracts = attracts && a[j][j] < 0.0;
        moving[j] = -below[which[j]];
    }
    for (int j = 0; j < n_moving; j++) {
        const int held = sim->head->events.resting[which[j]] == GB_HELD;
        moving[j] -= held ? bend_of_held(sim, which[j], at, lane, y) : 0.0;
    }
    const int solved = solve(n_moving, a, moving);
    for (int j = 0; j < n_moving; j++) {
        share[which[j]] = moving[j];
    }
    if (n_moving < n) {
        resting_shares(sim, at, lane, y, share);
    }
    return solved ? 1 + attracts : 0;
}

void gb_sliding_rates(gb_sim *sim, int full, const gb_lanes *at, int lane, const double *y, double *dy) {
    const gb_model *model = sim->model;
    const int length = full ? model->n_total : model->n_padded;
    const double *rates = sim->sliding.rates;
    double share[GB_SLIDING];
    if (!gb_find_shares(sim, full, at, lane, y, share)) {
        share[0] = NAN; /* the step is too long */
    }
    for (int i = 0; i < length; i++) {
        double sum = rates[i], size = fabs(rates[i]);
        for (int j = 0; j < sim->head->events.n_sliding; j++) {
            const double part = share[j] * (rates[(size_t)(1 + j) * (size_t)model->n_total + (size_t)i] - rates[i]);
            sum += part;
            size += fabs(part);
        }
        dy[i] = fabs(sum) <= ROUNDING * size ? 0.0 : sum; /* what is held at rest is at rest */
    }
}

void gb_mode_with_shares(gb_sim *sim, const gb_lanes *at, int lane, const double *y, double *mode) {
    double share[GB_SLIDING];
    const int found = gb_find_shares(sim, 0, at, lane, y, share);
    for (int j = 0; j < sim->head->events.n_sliding; j++) {
        mode[sim->head->events.sliding[j]] += found ? gb_min(gb_max(share[j], LEAST), 1.0 - LEAST) : 0.5;
    }
}
