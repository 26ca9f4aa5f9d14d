#include "gb_drift.h"
#include "gb_error_control.h"
#include "gb_ledger.h"
#include "gb_rounding_motion.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

#include <limits.h>

/* What a run may end with, in units of rtol times the turnover: less than the ledger promises. */
static const double GOAL = 3.0;

/* Part of that which must be there before anything is wrong, and while the turnover grows: a transient tells little of
 * the rest. */
static const double ENOUGH = 0.05, GROWING = 0.3;

/* Part of what the turnover would grow by until the end, as it has grown lately, that is counted on. */
static const double COUNTED_ON = 0.1;

/* Part of the goal that may be used up at once; the rest as time goes on: what departs in one part of a turn alone
 * looks right in the others. */
static const double LATEST = 0.2;

/* Part of the goal that is used up from where on looks are close together. */
static const double USED = 0.25;

/* Growth of the turnover from one look to the next up to which it is one that may be compared with. */
static const double GROWTH = 1.25;

/* Tolerance below which rounding would decide, and the strictest, as log2 of the part of the tolerance that is left;
 * from where on it must have helped. */
static const double LEAST = 1e-12, STRICTEST = 20.0, MOST_AT_ONCE = 3.0, LESS = 0.25, USELESS = 7.0;

/* Tolerances that one step may add; the power of the step size by which a shorter try of it must add less, else what is
 * out of balance is no error of steps, and that many steps, then twice as many, are not looked at; from where on, as
 * log2 of tolerances, it keeps the next step from growing as it could. */
static const double MOST_OF_A_STEP = 1.0, LEAST_POWER = 2.5, SLOWS = -16.0;
enum { LEFT_OUT = 16 };

/* Steps up to the first look, between two where something is wrong, and at most; events: a body that bounces is cut off
 * at the same place of each step, and misses by the same each time; how often strictness may be of no use. */
enum { FIRST = 12, SOON = 16, SELDOM = 128, EVENTS = 8, TRIES = 4 };

/* Stored and lost less supplied, at the front; *stored: the first alone. */
static int balance(gb_sim *sim, double *sum, double *stored) {
    const gb_model *model = sim->model;
    const int code = gb_time_terms_at(sim, sim->head->front.t1), first = gb_first_energy(model);
    *sum = *stored = 0.0;
    if (code != GB_DONE) {
        return code;
    }
    if (model->output_time_terms) {
        model->output_time_terms(sim->par, sim->mode, 1, sim->instant.t, sim->instant.u, sim->instant.time_terms);
    }
    model->energies(sim->par, sim->mode, sim->instant.time_terms, sim->y, sim->scratch.energies);
    for (int i = 0; i < model->n_energies; i++) {
        *sum += sim->scratch.energies[i];
        *stored += fabs(sim->scratch.energies[i]);
    }
    for (int i = first; i < gb_end_energy(model); i++) {
        *sum += model->energy_sign[i - first] * sim->y[i];
    }
    return code;
}

/* Stored and lost less supplied at lane `lane` of the step, where the state is y; *stored: the first alone. */
static double balance_at(gb_sim *sim, int lane, const double *y, double *stored) {
    const gb_model *model = sim->model;
    const int first = gb_first_energy(model);
    double sum = 0.0;
    model->energies(sim->par, sim->mode, sim->lanes.time_terms + lane, y, sim->scratch.energies);
    *stored = 0.0;
    for (int i = 0; i < model->n_energies; i++) {
        sum += sim->scratch.energies[i];
        *stored += fabs(sim->scratch.energies[i]);
    }
    for (int i = first; i < gb_end_energy(model); i++) {
        sum += model->energy_sign[i - first] * (y[i] - sim->y0[i]);
    }
    return sum;
}

double gb_log_imbalance(gb_sim *sim, double h) {
    const gb_method *method = sim->method;
    gb_head *head = sim->head;
    struct gb_drift *drift = &head->drift;
    double before, after;
    if (head->counts.steps < drift->balance_at) {
        return -100.0;
    }
    if (sim->model->output_time_terms) {
        sim->model->output_time_terms(sim->par, sim->mode, method->all_stages, sim->lanes.t, sim->lanes.u,
                                      sim->lanes.time_terms);
    }
    const double added = fabs(balance_at(sim, method->stages, sim->z, &after) - balance_at(sim, 0, sim->y0, &before));
    const double size = gb_max(head->ledger.stored, gb_max(before, after)) + head->ledger.turnover;
    const double tolerance = MOST_OF_A_STEP * gb_max(head->options.rtol, LEAST) * size;
    const double error = tolerance > 0.0 ? gb_rough_log2(added / tolerance + 1e-30) : -100.0;
    if (error > SLOWS && head->front.t1 > head->front.t_start && gb_moves_by_rounding(sim)) {
        return -100.0;
    }
    if (error > 0.0) {
        if (drift->imbalanced && error > drift->imbalance + LEAST_POWER * gb_rough_log2(h / drift->h_imbalance)) {
            drift->balance_gap = 2 * drift->balance_gap + LEFT_OUT;
            drift->balance_at = head->counts.steps + drift->balance_gap;
            return -100.0;
        }
        drift->imbalanced = 1;
        drift->imbalance = error;
        drift->h_imbalance = h;
    }
    return error;
}

/* The slower of the rates at which the turnover has grown since strictness was chosen and since the last look: what
 * dies away exchanges nothing more. */
static double growth_rate(const struct gb_drift *drift, double turnover, double t) {
    const double since = (turnover - drift->turnover_chosen) / (t - drift->t_chosen), look = t - drift->t_look;
    return gb_max(look > 0.0 ? gb_min(since, (turnover - drift->turnover) / look) : 0.0, 0.0);
}

/* Strictness for the rest of the run, at the mean rate at which the balance departs since it was chosen; whether
 * something is wrong. */
static int decide(gb_sim *sim, double turnover) {
    struct gb_drift *drift = &sim->head->drift;
    const double t = sim->head->front.t1, stop = sim->head->options.t_stop, since = t - drift->t_chosen;
    const double left = stop > t && stop < HUGE_VAL ? stop - t : t - sim->head->front.t_start;
    const double allowed = GOAL * sim->head->options.rtol, now = fabs(drift->sum), goal = allowed * turnover;
    const double rate = fabs(drift->sum - drift->chosen) / since, more = rate * left;
    const double strictest = gb_min(STRICTEST, log2(sim->head->options.rtol / LEAST));
    const int grows = turnover > GROWTH * drift->turnover;
    const double room = gb_max(goal - now, 0.2 * goal) + allowed * COUNTED_ON * growth_rate(drift, turnover, t) * left;
    drift->turnover = turnover;
    drift->t_look = t;
    if (more <= room || now < (grows ? GROWING : ENOUGH) * goal) {
        const double gone = t - sim->head->front.t_start, due = goal * (LATEST + (1.0 - LATEST) * gone / (gone + left));
        const int less = 4.0 * more < room && 2.0 * now < due;
        drift->strictness = gb_max(0.0, drift->strictness - (less ? LESS : 0.0));
        return 4.0 * more > room || now > USED * goal;
    }
    if (drift->strictness <= 0.0) {
        drift->rate = gb_max(drift->rate, rate / turnover);
    }
    const int most = drift->strictness > gb_min(USELESS, strictest - LESS);
    drift->tries = most && rate / turnover > 0.5 * drift->rate ? drift->tries + 1 : 0;
    drift->strictness += gb_max(0.0, gb_min(1.0 + log2(more / room), MOST_AT_ONCE));
    drift->strictness = gb_min(drift->strictness, strictest);
    drift->chosen = drift->sum;
    drift->t_chosen = t;
    drift->turnover_chosen = turnover;
    return 1;
}

int gb_drift_look(gb_sim *sim) {
    gb_head *head = sim->head;
    struct gb_drift *drift = &head->drift;
    double sum, stored;
    if (!sim->model->energy_sign || head->options.step > 0.0 || !head->options.locate ||
        !(head->options.rtol >= LEAST)) {
        drift->look_at = drift->look_event = LLONG_MAX;
        return GB_DONE;
    }
    const int code = balance(sim, &sum, &stored), first = drift->gap == 0;
    int soon = 1;
    head->ledger.stored = gb_max(head->ledger.stored, stored);
    if (first) {
        drift->t_chosen = drift->t_look = head->front.t1;
        drift->turnover_chosen = head->ledger.turnover + head->ledger.stored;
    } else if (drift->based) {
        drift->sum += sum - drift->last;
        soon = head->front.t1 > drift->t_chosen && !gb_moves_by_rounding(sim) &&
               decide(sim, head->ledger.turnover + head->ledger.stored);
    }
    drift->gap = first ? FIRST : soon ? SOON : drift->gap < SELDOM / 2 ? 2 * drift->gap : SELDOM;
    drift->look_at = head->counts.steps + drift->gap;
    drift->look_event = head->counts.events + EVENTS;
    drift->based = 1;
    drift->last = sum;
    if (drift->tries >= TRIES) { /* no error of steps: whatever it is, shorter ones do not help */
        drift->strictness = 0.0;
        drift->look_at = drift->look_event = LLONG_MAX;
    }
    return code;
}
