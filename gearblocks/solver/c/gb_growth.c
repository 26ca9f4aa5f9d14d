#include "gb_growth.h"
#include "gb_error_control.h"
#include "gb_progress.h"
#include "gb_report.h"
#include "gb_vector.h"

/* A wrong step weighs as much as four right ones: where contacts cut steps short, some of them are right by that. */
enum { WEIGHT = 4, MOST_WRONG = 24 * WEIGHT };

/* A rate so large that the rest of the run cannot tell the time in which the value doubles. */
static const double SUDDEN = 1e10;

/* Values near the end of the range of numbers. */
static const double HUGE_STATE = 1e100;

/* Steps before the first look at the pace; the next is after twice as many. */
static const double FIRST_LOOK = 65536.0;

/* rad/s or m/s: no machine is so fast. */
static const double BEYOND_MACHINES = 1e9;

/* From look to look: what the speed grows by, what the pace falls to, and how many times as long is left. */
static const double GROWS = 2.0, FALLS = 0.75, LEFT = 4.0;

/* What steps from look to look must bring the run on by, as a part of what is left. */
static const double LEAST_PROGRESS = 1e-10;

/* The state that grows quickest of those near their largest value; -1: none grows. */
static int fastest(const gb_sim *sim, double *pace) {
    int found = -1;
    *pace = 0.0;
    for (int i = 0; i < sim->model->n; i++) {
        const double y = sim->y[i], rate = sim->k1[i];
        if (y * rate > 0.0 && fabs(y) >= 0.9 * sim->control.largest[i] && fabs(rate) > *pace * fabs(y)) {
            *pace = fabs(rate / y);
            found = i;
        }
    }
    return found;
}

/* Growth without bound: that of the motion, or that of fixed steps that have been wrong. */
static int fail(gb_sim *sim, int index, double value) {
    const gb_head *head = sim->head;
    return head->growth.wrong > 0 ? gb_fail(sim, GB_ERR_UNSTABLE, index, head->front.t1, head->options.step)
                                  : gb_fail(sim, GB_ERR_ESCAPE, index, head->front.t1, value);
}

int gb_watch_fixed_step(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    gb_head *head = sim->head;
    double worst = 0.0, coordinates = 0.0, speeds = 0.0;
    int index = 0;
    for (int i = 0; i < model->n; i++) {
        double *kind = i < model->n - model->n_speeds ? &coordinates : &speeds;
        *kind = gb_max(*kind, gb_max(sim->control.largest[i], fabs(sim->z[i])));
    }
    for (int b = 0; b < model->n_padded; b += GB_PAD) {
        for (int e = 0; e < sim->method->n_errors; e++) {
            double error[GB_PAD];
            gb_combine(&sim->method->e[e], sim->k + b, model->n_total, 0, GB_PAD, sim->zero, h, error);
            for (int i = b; i < b + GB_PAD && i < model->n; i++) {
                const double own = gb_max(sim->control.largest[i], fabs(sim->z[i])),
                             least = i < model->n - model->n_speeds ? 1e-8 * coordinates : 1e-6 * speeds,
                             size = gb_max(gb_max(own, sim->control.natural_scale[i]), least);
                const double ratio = size > 0.0 ? fabs(error[i - b]) / size : 0.0;
                index = ratio > worst ? i : index;
                worst = gb_max(worst, ratio);
            }
        }
    }
    if (worst > 0.25) {
        head->growth.wrong += WEIGHT;
        return head->growth.wrong > MOST_WRONG ? gb_fail(sim, GB_ERR_UNSTABLE, index, head->front.t1, h) : GB_DONE;
    }
    head->growth.wrong -= head->growth.wrong > 0;
    return GB_DONE;
}

int gb_name_growth(gb_sim *sim) {
    double pace;
    return fail(sim, fastest(sim, &pace), sim->head->ledger.turnover);
}

int gb_watch_pace(gb_sim *sim, double target) {
    const gb_model *model = sim->model;
    struct gb_growth *growth = &sim->head->growth;
    const double steps = (double)sim->head->counts.steps;
    if (steps < gb_max(growth->look_at, FIRST_LOOK)) {
        return GB_DONE;
    }
    int fast = model->n - model->n_speeds;
    for (int i = fast; i < model->n; i++) {
        fast = sim->control.largest[i] > sim->control.largest[fast] ? i : fast;
    }
    const double t = sim->head->front.t1, from = growth->look_at > 0.0 ? growth->t_look : sim->head->front.t_start;
    const double since = t - from;
    const double speed = model->n_speeds > 0 ? sim->control.largest[fast] : 0.0, pace = since / steps;
    const int escapes = growth->look_at > 0.0 && speed > gb_max(BEYOND_MACHINES, GROWS * growth->speed) &&
                        pace < FALLS * growth->pace && target - t > LEFT * since;
    growth->look_at = 2.0 * steps;
    growth->t_look = t;
    growth->pace = pace;
    growth->speed = speed;
    if (since < LEAST_PROGRESS * gb_rest_of_run(sim, target)) {
        return gb_fail(sim, GB_ERR_STALL, gb_worst_state(sim), t, steps);
    }
    return escapes ? fail(sim, fast, sim->y[fast]) : GB_DONE;
}

int gb_name_escape(gb_sim *sim, int code) {
    const gb_head *head = sim->head;
    const double t = head->front.t1;
    double pace;
    const int found = fastest(sim, &pace);
    const int sudden = found >= 0 && pace * (t - head->front.t_start) > SUDDEN && head->counts.steps > 1;
    const int far = found >= 0 && code == GB_ERR_NAN_RATE && fabs(sim->y[found]) > HUGE_STATE;
    return sudden || far ? fail(sim, found, sim->y[found]) : code;
}
