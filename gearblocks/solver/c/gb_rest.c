#include "gb_rest.h"
#include "gb_constraint_state.h"
#include "gb_noise.h"
#include "gb_rates.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

/* The window: short beside the motions of a drivetrain, long beside what rounding leaves of a soft rise. */
static const double WINDOW = 1e-3;

/* Part of its rate at the end of the window that a speed may have at its start: rounding, of forces that cancel. */
static const double SOFT = 0.1;

/* Looks inside the window, each at half the time of the one before; how often it is halved at most. */
enum { PARTS = 4, MOST_HALVINGS = 20 };

/* Part of a rate that counts as rounding, of forces that cancel. */
static const double ROUNDING = 1e-6;

/* The first speed; where a model does not know its speeds, all states are like them. */
static int first_speed(const gb_model *model) {
    return model->n_speeds > 0 ? model->n - model->n_speeds : 0;
}

int gb_has_moved(const gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = first_speed(model); i < model->n; i++) {
        if (sim->control.largest[i] > 0.0 || sim->control.natural_scale[i] > 0.0) {
            return 1;
        }
    }
    return model->n == 0;
}

/* Accelerations that are rounding of what locks hold. */
static const double *rounding_of_locks(gb_sim *sim) {
    double *left = sim->k + (size_t)GB_SPARE * (size_t)sim->model->n_total;
    if (!gb_some_active(sim)) {
        return sim->zero;
    }
    gb_noise_of_locks(sim, sim->instant.time_terms, sim->y, left);
    return left;
}

/* Every speed that moves now does so much faster at the end of the window. */
static int is_soft(const gb_sim *sim, const double *left, const double *later) {
    for (int i = first_speed(sim->model); i < sim->model->n; i++) {
        if (fabs(sim->k1[i]) > gb_max(SOFT * fabs(later[i]), left[i])) {
            return 0;
        }
    }
    return 1;
}

/* Natural scales of the states in [from, to) that rest, and of their rates, from those over the window that are more
 * than rounding; adds what they change to z2. */
static double drive(gb_sim *sim, int from, int to, double window, const double *left, const double *rate) {
    double most = 0.0;
    sim->head->control.natural = -1.0;
    for (int i = from; i < to; i++) {
        const double change = window * rate[i];
        if (fabs(rate[i]) > left[i] && fabs(change) < HUGE_VAL && sim->control.largest[i] == 0.0) {
            sim->control.natural_scale[i] = gb_max(sim->control.natural_scale[i], fabs(change));
            sim->control.fastest_rate[i] = gb_max(sim->control.fastest_rate[i], fabs(rate[i]));
            sim->z2[i] += change;
            most = gb_max(most, fabs(change));
        }
    }
    return most;
}

/* The rates at the front's state after a time. */
static int rates_after(gb_sim *sim, double time, double *rate) {
    const int code = gb_time_terms_at(sim, sim->head->front.t1 + time);
    if (code == GB_DONE) {
        gb_rates(sim, 0, &sim->instant, 0, sim->y, rate);
        sim->head->counts.rhs_calls++;
    }
    return code == GB_DONE;
}

/* The rates at the end of the window; 1: earlier parts of it drive every speed the same way, but for rounding. */
static int same_way(gb_sim *sim, double window, const double *left, double *rate, double *early) {
    const gb_model *model = sim->model;
    int same = rates_after(sim, window, rate);
    for (int part = 0; part < PARTS && same; part++) {
        window *= 0.5;
        same = rates_after(sim, window, early);
        for (int i = first_speed(model); i < model->n && same; i++) {
            same = fabs(rate[i]) <= left[i] || !(rate[i] * early[i] < -ROUNDING * rate[i] * rate[i]);
        }
    }
    return same;
}

int gb_scales_from_rest(gb_sim *sim) {
    const gb_model *model = sim->model;
    gb_head *head = sim->head;
    const int speeds = first_speed(model);
    double *rate = sim->k + (size_t)(GB_STAGES - 1) * (size_t)model->n_total, energy = 0.0;
    double window = gb_min(WINDOW, head->events.t_break - head->front.t1);
    int halvings = 0;
    if (!gb_is_at_rest(sim)) {
        return 0;
    }
    const double *left = rounding_of_locks(sim);
    /* what turns round inside the window (a dip of a friction torque is over) never comes to the speed of its end */
    while (!same_way(sim, window, left, rate, rate - model->n_total)) {
        if (++halvings > MOST_HALVINGS) {
            return 0;
        }
        window *= 0.5;
    }
    memcpy(sim->z2, sim->y, sizeof(double) * (size_t)model->n_total);
    if (!is_soft(sim, left, rate) || !(drive(sim, speeds, model->n, window, left, rate) > 0.0)) {
        return 0;
    }
    gb_rates(sim, 1, &sim->instant, 0, sim->z2, rate);
    head->counts.rhs_calls++;
    drive(sim, 0, speeds, window, sim->zero, rate);
    for (int i = model->n_padded + model->n_angles; i < model->n_padded + model->n_quadratures; i++) {
        energy += window * fabs(rate[i]);
    }
    head->ledger.stored = gb_max(head->ledger.stored, energy < HUGE_VAL ? energy : 0.0);
    return 1;
}
