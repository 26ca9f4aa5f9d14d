#include "gb_cut.h"
#include "gb_defect.h"
#include "gb_error_control.h"
#include "gb_event_values.h"
#include "gb_modes.h"
#include "gb_rosenbrock.h"
#include "gb_vector.h"

/* How often a step is tried again for one of these. */
enum { MOST_AGAIN = 8, MOST_DOUBTS = 3, MOST_CUTS = 2 };

/* A step of fewer roundings of the time than these locates what jumps in an event function: no polynomial follows that
 * in any step, and the end of this one tells where it is. */
static const double LEAST_AGAIN = 64.0, SHORTER = 0.25;

/* A step that is wrong where it is cut is tried again up to a little beyond its event: one that ended there would leave
 * the limit to rounding. */
static const double BEYOND = 1.0 + 1e-6;

/* A shorter part of an implicit step is right, which says nothing of other steps; the least part that is tried next
 * where an event is told by the error of the step. */
static const double NO_PART = 1e-9, LEAST_PART = 1e-4;

/* Points of Gauss and Legendre in [0, 1]: of the part of a step that an event ends the defect is integrated. */
static const double AT[] = {0.1127016653792583, 0.5, 0.8872983346207417},
                    WEIGHT[] = {0.2777777777777778, 0.4444444444444444, 0.2777777777777778};

/* An error below this, as log2, is none if it were so in the whole step, and so is one below the tolerance that differs
 * by no more than this from the last in the same modes: the next event in these is not looked at, twice as many after
 * the next such error, at most MOST. */
static const double NONE = -1.5, ALIKE = 0.3;
enum { MOST = 128 };

/* A pending event is told by an error of the states: up to theta its event function has moved by less than ten times
 * what that makes of it. */
static int is_told_by_error(gb_sim *sim, double theta, const double *error, double gain) {
    int told = 0;
    if (gb_event_functions_at(sim, theta, sim->events.s) == GB_DONE) {
        for (int i = 0; i < sim->model->n; i++) {
            sim->z2[i] += gain * error[i];
        }
        sim->model->event_functions(sim->par, sim->mode, sim->instant.time_terms, sim->z2, sim->events.moved);
        for (int i = 0; i < sim->model->n_event_functions; i++) {
            const double s = sim->events.s[i], off = sim->events.moved[i] - s;
            told |= sim->events.pending[i] != 0.0 && fabs(s - sim->events.s0[i]) < 10.0 * fabs(off);
        }
    }
    return told;
}

/* log2 of the error at theta: the integral of the defect up to there. An implicit step damps it by the rates of the
 * modes that end at theta; where the event is told by that error it may have been long before, and nothing is damped
 * since: `blind`. */
static double log_error_at(gb_sim *sim, double theta, int *blind) {
    const double h = sim->head->front.h;
    const int n = sim->model->n, total = sim->model->n_total;
    double *slope = sim->events.defect, *rate = slope + total, *sum = rate + total;
    memset(sum, 0, sizeof(double) * (size_t)n);
    for (int j = 0; j < 3 && gb_slopes_at(sim, AT[j] * theta, h); j++) {
        for (int i = 0; i < n; i++) {
            sum[i] += WEIGHT[j] * theta * (slope[i] - h * rate[i]);
        }
    }
    *blind = 0;
    if (sim->method->gamma > 0.0) {
        const double undamped = gb_largest_defect(sim, sum, h);
        gb_rosenbrock_response(sim, sum);
        const double error = gb_largest_defect(sim, sum, h) / sim->method->gamma;
        *blind = undamped > gb_max(error, 1.0) && is_told_by_error(sim, theta, sum, 1.0 / (sim->method->gamma * theta));
        return gb_rough_log2((*blind ? undamped : error) + 1e-30);
    }
    return gb_rough_log2(gb_largest_defect(sim, sum, h) + 1e-30);
}

/* A step is wrong where it is cut, though right at its end: beyond the event its stages take a law that bends otherwise
 * (k g abs(g)^(n - 1) through g = 0), and of the sizes that are tried one is found for which the estimate passes zero.
 * Returns the part that is to be tried, 1: none. */
static double part_if_wrong(gb_sim *sim, double theta) {
    struct gb_pace *control = &sim->head->control;
    const int implicit = sim->method->gamma > 0.0;
    const uint64_t modes = sim->head->events.mode_hash + (uint64_t)implicit; /* each kind has errors of its own */
    const long long events = sim->head->counts.events;
    int blind = 0;
    if ((implicit && theta < NO_PART) || gb_is_patient(&control->cuts, modes, events)) {
        return 1.0;
    }
    double *last = &control->cut_error[modes % GB_MEMORY];
    const double error = log_error_at(sim, theta, &blind), whole = error - gb_rough_log2(theta + 1e-30);
    const int alike = gb_was_looked_at(&control->cuts, modes) && fabs(error - *last) < ALIKE;
    *last = error;
    gb_looked(&control->cuts, modes, events, whole < (alike ? 0.0 : NONE) ? MOST : 0);
    if (!(error > 0.0) || (sim->events.again >= MOST_CUTS && !blind)) {
        return 1.0;
    }
    return blind ? theta * gb_max(gb_rough_exp2(-error), LEAST_PART) : BEYOND * theta;
}

double gb_part_in_question(gb_sim *sim, double theta) {
    const gb_head *head = sim->head;
    const int again = sim->events.again;
    const int tries = sim->events.undersampled ? MOST_AGAIN : sim->events.in_doubt ? MOST_DOUBTS : 0;
    if (head->options.step > 0.0) {
        return 1.0;
    }
    if (again < tries && head->front.h > LEAST_AGAIN * gb_rounding(head->front.t0, head->control.h_largest)) {
        return SHORTER;
    }
    return BEYOND * theta < 1.0 && again < (sim->method->gamma > 0.0 ? MOST_AGAIN : MOST_CUTS)
               ? part_if_wrong(sim, theta)
               : 1.0;
}
