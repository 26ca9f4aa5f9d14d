#include "gb_exact_limit.h"
#include "gb_evaluate.h"
#include "gb_modes.h"
#include "gb_rates.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

/* How far ahead is looked, as part of the time to the next announced instant or of a step; and how long, as part of the
 * largest step, what follows the motion keeps the side that it came to by itself: a law that leaves its limit wherever
 * it stands there would go back and forth. What goes to a side has gone farther after twice the time by more than
 * rounding does. */
static const double AHEAD = 1e-3, PATIENCE = 1e-6, FARTHER = 1.5;

/* -1 or 1: event function i, which has just flipped, would be s, on the side of its limit that it came from. */
static double is_back(const gb_sim *sim, int i, double s) {
    const double armed = sim->events.armed[i];
    return armed < 0.0 ? (s < sim->events.lo[i] ? -1.0 : 0.0) : armed > 0.0 && s > sim->events.hi[i];
}

/* Whether the k-th switch is exactly on a limit, or back and only time moves it, and nothing else decides about it. */
static int is_asked(const gb_sim *sim, int k) {
    const int i = sim->model->exact_switches[k], back = is_back(sim, i, sim->events.s[i]) != 0.0;
    const double s = sim->events.s[i];
    const int there = s == sim->events.lo[i] || s == sim->events.hi[i] || (back && k < sim->model->n_exact_timed);
    return there && s - s == 0.0 && sim->events.role[i] == GB_ORDINARY && !gb_slides(sim, i);
}

static int any_is_asked(const gb_sim *sim) {
    int k = 0;
    while (k < sim->model->n_exact_switches && !is_asked(sim, k)) {
        k++;
    }
    return k < sim->model->n_exact_switches;
}

/* A short time, before anything that is announced. */
static double soon(const gb_sim *sim) {
    const gb_head *head = sim->head;
    const double t = head->front.t1, step = head->control.h_worked;
    double ahead = gb_min(head->events.t_break, head->options.t_stop) - t;
    if (!(ahead < HUGE_VAL) || (step > 0.0 && step < ahead)) {
        ahead = step > 0.0 ? step : gb_max(fabs(t), 1.0);
    }
    return AHEAD * gb_max(ahead, 0.0);
}

/* Event functions so much later, as the present modes move them. */
static int look_ahead(gb_sim *sim, double ahead, double *later) {
    const gb_model *model = sim->model;
    const double t = sim->head->front.t1;
    double *rate = sim->sliding.rates, *y = rate + model->n_total;
    int code = gb_time_terms_at(sim, t);
    if (code != GB_DONE) {
        return code;
    }
    gb_mode_rates(sim, 0, &sim->instant, 0, sim->y, rate);
    for (int i = 0; i < model->n_total; i++) {
        y[i] = sim->y[i] + ahead * (rate[i] - rate[i] == 0.0 ? rate[i] : 0.0);
    }
    code = gb_time_terms_at(sim, t + ahead);
    if (code == GB_DONE) {
        model->event_functions(sim->par, sim->mode, sim->instant.time_terms, y, later);
        code = gb_time_terms_at(sim, t);
    }
    return code;
}

/* The mode of the k-th switch, which is on a limit or back, from its values now, soon and after twice the time; its own
 * where they do not tell. What goes on from where it is back has not passed: others that flip at the same instant have
 * carried it there. */
static double mode_from(gb_sim *sim, int k, double soon, double later) {
    const int i = sim->model->exact_switches[k], moves = k >= sim->model->n_exact_timed;
    const double s = sim->events.s[i], back = is_back(sim, i, s);
    if (back != 0.0) {
        const int goes_on = is_back(sim, i, soon) == back && is_back(sim, i, later) == back;
        return goes_on ? sim->model->mode_at(sim->par, i, s) : sim->mode[i];
    }
    const double since = sim->head->front.t1 - sim->events.stayed[i];
    const int stays = soon == s && later == s, goes = fabs(later - s) >= FARTHER * fabs(soon - s) && soon != s;
    if (moves && (!stays || since <= PATIENCE * sim->head->control.h_largest)) {
        return sim->mode[i];
    }
    return stays ? sim->model->mode_at(sim->par, i, s) : goes ? sim->model->mode_at(sim->par, i, soon) : sim->mode[i];
}

int gb_take_exact_modes(gb_sim *sim, int log, int *changed) {
    const gb_model *model = sim->model;
    double *first = sim->sliding.functions, *second = sim->events.moved;
    gb_mode_limits(sim);
    int code = gb_event_functions_now(sim);
    if (code != GB_DONE || !any_is_asked(sim)) {
        return code;
    }
    code = look_ahead(sim, soon(sim), first);
    code = code == GB_DONE ? look_ahead(sim, 2.0 * soon(sim), second) : code;
    for (int k = 0; k < model->n_exact_switches && code == GB_DONE; k++) {
        const int i = model->exact_switches[k];
        const double mode = is_asked(sim, k) ? mode_from(sim, k, first[i], second[i]) : sim->mode[i];
        if (mode != sim->mode[i]) {
            gb_set_mode(sim, i, mode, log && sim->events.role[i] == GB_ORDINARY);
            sim->events.armed[i] = 0.0;
            sim->events.stayed[i] = sim->head->front.t1;
            *changed += 1;
        }
    }
    return code;
}
