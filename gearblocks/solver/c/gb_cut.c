#include "gb_cut.h"
#include "gb_defect.h"
#include "gb_error_control.h"
#include "gb_modes.h"
#include "gb_rosenbrock.h"

/* How often a step is tried again for one of these. */
enum { MOST_AGAIN = 8, MOST_DOUBTS = 3, MOST_CUTS = 2 };

/* A step of fewer roundings of the time than these locates what jumps in an event function: no polynomial follows that
 * in any step, and the end of this one tells where it is. */
static const double LEAST_AGAIN = 64.0, SHORTER = 0.25;

/* A step that is wrong where it is cut is tried again up to a little beyond its event: one that ended there would leave
 * the limit to rounding. */
static const double BEYOND = 1.0 + 1e-6;

/* Points of Gauss and Legendre in [0, 1]: of the part of a step that an event ends the defect is integrated. */
static const double AT[] = {0.1127016653792583, 0.5, 0.8872983346207417},
                    WEIGHT[] = {0.2777777777777778, 0.4444444444444444, 0.2777777777777778};

/* An error below this, as log2, is none if it were so in the whole step, and so is one below the tolerance that differs
 * by no more than this from the last in the same modes: the next event in these is not looked at, twice as many after
 * the next such error, at most MOST. */
static const double NONE = -1.5, ALIKE = 0.3;
enum { MOST = 128 };

/* log2 of the error at theta: the integral of the defect up to there. */
static double log_error_at(gb_sim *sim, double theta) {
    const double h = sim->head->front.h;
    const int n = sim->model->n, total = sim->model->n_total;
    double *slope = sim->events.defect, *rate = slope + total, *sum = rate + total;
    memset(sum, 0, sizeof(double) * (size_t)n);
    for (int j = 0; j < 3 && gb_slopes_at(sim, AT[j] * theta, h); j++) {
        for (int i = 0; i < n; i++) {
            sum[i] += WEIGHT[j] * theta * (slope[i] - h * rate[i]);
        }
    }
    if (sim->method->gamma > 0.0) {
        gb_rosenbrock_response(sim, sum);
    }
    return gb_rough_log2(gb_largest_defect(sim, sum, h) / (sim->method->gamma > 0.0 ? sim->method->gamma : 1.0) +
                         1e-30);
}

/* A step is wrong where it is cut, though right at its end: beyond the event its stages take a law that bends otherwise
 * (k g abs(g)^(n - 1) through g = 0), and of the sizes that are tried one is found for which the estimate passes zero.
 */
static int is_wrong(gb_sim *sim, double theta) {
    struct gb_pace *control = &sim->head->control;
    const uint64_t modes = sim->head->events.mode_hash;
    const long long events = sim->head->counts.events;
    if (gb_is_patient(&control->cuts, modes, events)) {
        return 0;
    }
    double *last = &control->cut_error[modes % GB_MEMORY];
    const double error = log_error_at(sim, theta), whole = error - gb_rough_log2(theta + 1e-30);
    const int alike = gb_was_looked_at(&control->cuts, modes) && fabs(error - *last) < ALIKE;
    *last = error;
    gb_looked(&control->cuts, modes, events, whole < (alike ? 0.0 : NONE) ? MOST : 0);
    return error > 0.0;
}

double gb_part_again(gb_sim *sim, double theta) {
    const gb_head *head = sim->head;
    const int again = sim->events.again,
              longer = head->front.h > LEAST_AGAIN * gb_rounding(head->front.t0, head->control.h_largest);
    if (head->options.step > 0.0) {
        return 1.0;
    }
    if (longer && again < (sim->events.undersampled ? MOST_AGAIN : sim->events.in_doubt ? MOST_DOUBTS : 0)) {
        return SHORTER;
    }
    const double part = BEYOND * theta;
    return part < 1.0 && again < MOST_CUTS && is_wrong(sim, theta) ? part : 1.0;
}
