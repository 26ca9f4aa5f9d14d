#include "gb_limit_hold.h"
#include "gb_constraint_state.h"
#include "gb_rates.h"
#include "gb_time_terms.h"
#include "gb_tolerance.h"
#include "gb_vector.h"

static const double UNTOLD = 1e-3;  /* of the tolerance: the speed that is taken for none */
static const double NARROW = 1e-1;  /* of the tolerance: swings that are taken for none */
static const double SHORT = 1e-3;   /* of the largest step: flips that are looked at */
static const double APART = 1e-4;   /* rad or m, of differences */
static const double NOTHING = 1e-6; /* of the jump: what the motion of others adds to it */

/* How fast the event function changes along rates f of the coordinates alone. */
static double speed_along(gb_sim *sim, const double *f, double apart) {
    double speed[GB_SLIDING];
    gb_speeds_along(sim, f, &sim->instant, 0, sim->y, apart, 0.0, speed);
    return speed[sim->head->events.n_sliding - 1];
}

/* It reads speeds or time themselves: what they are without the motion. */
static int reads_more(gb_sim *sim, int i) {
    const gb_model *model = sim->model;
    const double t = sim->head->front.t1;
    double *y = sim->sliding.state, *s = sim->sliding.functions;
    model->event_functions(sim->par, sim->mode, sim->instant.time_terms, sim->y, s);
    const double here = s[i];
    memcpy(y, sim->y, sizeof(double) * (size_t)model->n_padded);
    for (int j = model->n - model->n_speeds; j < model->n; j++) {
        y[j] = 1.0 + fmod((j + 1) * 0.6180339887498949, 1.0);
    }
    model->event_functions(sim->par, sim->mode, sim->instant.time_terms, y, s);
    int reads = s[i] != here || gb_time_terms_at(sim, t + gb_max(1e-3 * sim->head->control.h_next, 1e-9)) != GB_DONE;
    if (!reads) {
        model->event_functions(sim->par, sim->mode, sim->instant.time_terms, sim->y, s);
        reads = s[i] != here;
    }
    return gb_time_terms_at(sim, t) != GB_DONE || reads;
}

/* What the tolerances of speeds admit for the rate of the event function. */
static double tolerance_of_rate(gb_sim *sim, double *rate) {
    const gb_model *model = sim->model;
    double sum = 0.0;
    for (int j = model->n - model->n_speeds; j < model->n; j++) {
        const double weight = sim->control.error_weight[j];
        double speed[GB_SLIDING];
        memset(rate, 0, sizeof(double) * (size_t)model->n_total);
        rate[j] = 1.0;
        if (weight > 0.0) {
            gb_accelerations_along(sim, rate, &sim->instant, 0, sim->y, speed);
            sum += fabs(speed[sim->head->events.n_sliding - 1]) / weight;
        }
    }
    return sum;
}

/* What the motion of all others makes of the rate of the rate: by three points along it. rate: of the coordinates, the
 * largest of them is `most`. */
static double bends(gb_sim *sim, int i, const double *rate, double most) {
    const gb_model *model = sim->model;
    const int first = model->n - model->n_speeds;
    const double apart = APART / most;
    double *y = sim->z2, *s = sim->sliding.functions, second = 0.0;
    double *change = sim->sliding.rates + 2 * (size_t)model->n_total, *there = change + model->n_total;
    memset(change, 0, sizeof(double) * (size_t)model->n_total);
    for (int side = -1; side <= 1; side++) {
        memcpy(y, sim->y, sizeof(double) * (size_t)model->n_total);
        for (int j = 0; j < first; j++) {
            y[j] += side * apart * rate[j];
        }
        model->event_functions(sim->par, sim->mode, sim->instant.time_terms, y, s);
        second += (side ? 1.0 : -2.0) * s[i] / (apart * apart);
        model->rhs(sim->par, sim->mode, sim->instant.time_terms, y, there);
        for (int j = 0; j < first; j++) {
            change[j] += 0.5 * side / apart * there[j];
        }
    }
    double largest = 0.0;
    for (int j = 0; j < first; j++) {
        largest = gb_max(largest, fabs(change[j]));
    }
    return fabs(second) + (largest > 0.0 ? fabs(speed_along(sim, change, APART / largest)) : 0.0);
}

/* Its swings end: so slow, or so low. */
static int ends(gb_sim *sim, int i, double speed, double since, double *room) {
    const int narrow = since > 0.0 && since <= SHORT * sim->head->control.h_largest &&
                       since * fabs(speed) <= NARROW * gb_tolerance_of(sim, i);
    return narrow || fabs(speed) <= UNTOLD * tolerance_of_rate(sim, room);
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
        if (model->constraints[c].kind == GB_FRICTION && !gb_is_active(sim, c) &&
            sim->mode[model->constraints[c].slip] != 0.0 &&
            fabs(slip - impulse * (other[c] - one[c])) <= 0.5 * fabs(slip)) {
            return 1;
        }
    }
    return 0;
}

int gb_hold_last(gb_sim *sim, double since) {
    const gb_model *model = sim->model;
    const int n = sim->head->events.n_sliding, i = sim->head->events.sliding[n - 1], first = model->n - model->n_speeds;
    double *below = sim->sliding.rates, *above = below + model->n_total, *room = above + model->n_total, most = 0.0;
    double speed[2][GB_SLIDING], bend = 0.0;
    if (reads_more(sim, i)) {
        return 0;
    }
    model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->y, room);
    for (int j = 0; j < model->n; j++) {
        room[j] = j < first ? room[j] : 0.0;
        most = gb_max(most, fabs(room[j]));
    }
    const double rate = most > 0.0 ? speed_along(sim, room, APART / most) : 0.0;
    if (!ends(sim, i, rate, since, room)) {
        return 0;
    }
    if (most > 0.0) {
        model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->y, below);
        bend = bends(sim, i, below, most);
    }
    model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->y, below);
    gb_set_above(sim, 1 << (n - 1));
    model->rhs(sim->par, sim->sliding.mode, gb_terms_above(sim, &sim->instant, 0), sim->y, above);
    gb_accelerations_along(sim, below, &sim->instant, 0, sim->y, speed[0]);
    gb_accelerations_along(sim, above, &sim->instant, 0, sim->y, speed[1]);
    const double jump = speed[1][n - 1] - speed[0][n - 1];
    if (!(jump < 0.0) || bend > -NOTHING * jump || rubs_by_swings(sim, below, above, rate / jump)) {
        return 0;
    }
    for (int j = first; j < model->n; j++) {
        sim->y[j] -= rate / jump * (above[j] - below[j]);
    }
    return 1;
}
