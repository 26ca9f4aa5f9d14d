#include "gb_exact_limit.h"
#include "gb_evaluate.h"
#include "gb_modes.h"
#include "gb_rates.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

/* How far ahead is looked, as part of the time to the next announced instant or of a step; and how long, as part of the
 * largest step, what follows the motion keeps the side that it came to by itself: a law that leaves its limit wherever
 * it stands there would go back and forth. */
static const double AHEAD = 1e-3, PATIENCE = 1e-6;

/* Whether switch i, the k-th that may stay on a limit, is there, in the mode of the other side. */
static int is_apart(const gb_sim *sim, int k) {
    const gb_model *model = sim->model;
    const int i = model->exact_switches[k], moves = k >= model->n_exact_timed;
    const double s = sim->events.s[i], since = sim->head->front.t1 - sim->events.stayed[i];
    return (s == sim->events.lo[i] || s == sim->events.hi[i]) && model->mode_at(sim->par, i, s) != sim->mode[i] &&
           !gb_slides(sim, i) && !(moves && since <= PATIENCE * sim->head->control.h_largest);
}

static int any_is_apart(const gb_sim *sim) {
    int k = 0;
    while (k < sim->model->n_exact_switches && !is_apart(sim, k)) {
        k++;
    }
    return k < sim->model->n_exact_switches;
}

/* An instant after the front, before anything that is announced. */
static double soon(const gb_sim *sim) {
    const gb_head *head = sim->head;
    const double t = head->front.t1, step = head->control.h_worked;
    double ahead = gb_min(head->events.t_break, head->options.t_stop) - t;
    if (!(ahead < HUGE_VAL) || (step > 0.0 && step < ahead)) {
        ahead = step > 0.0 ? step : gb_max(fabs(t), 1.0);
    }
    return t + AHEAD * gb_max(ahead, 0.0);
}

/* Event functions a little later, as the present modes move them, into `later`. */
static int look_ahead(gb_sim *sim, double *later) {
    const gb_model *model = sim->model;
    const double t = sim->head->front.t1, then = soon(sim);
    double *rate = sim->sliding.rates, *y = rate + model->n_total;
    int code = gb_time_terms_at(sim, t);
    if (code != GB_DONE) {
        return code;
    }
    gb_mode_rates(sim, 0, &sim->instant, 0, sim->y, rate);
    for (int i = 0; i < model->n_total; i++) {
        y[i] = sim->y[i] + (then - t) * (rate[i] - rate[i] == 0.0 ? rate[i] : 0.0);
    }
    code = gb_time_terms_at(sim, then);
    if (code == GB_DONE) {
        model->event_functions(sim->par, sim->mode, sim->instant.time_terms, y, later);
        code = gb_time_terms_at(sim, t);
    }
    return code;
}

int gb_take_exact_modes(gb_sim *sim, int *changed) {
    const gb_model *model = sim->model;
    double *later = sim->sliding.functions;
    gb_mode_limits(sim);
    int code = gb_event_functions_now(sim);
    if (code == GB_DONE && any_is_apart(sim)) {
        code = look_ahead(sim, later);
        for (int k = 0; k < model->n_exact_switches && code == GB_DONE; k++) {
            const int i = model->exact_switches[k];
            if (later[i] == sim->events.s[i] && is_apart(sim, k)) {
                gb_set_mode(sim, i, model->mode_at(sim->par, i, sim->events.s[i]), sim->events.role[i] == GB_ORDINARY);
                sim->events.armed[i] = 0.0;
                sim->events.stayed[i] = sim->head->front.t1;
                *changed += 1;
            }
        }
    }
    return code;
}
