#include "gb_locate_sampled.h"
#include "gb_dense_output.h"
#include "gb_event_values.h"
#include "gb_force_noise.h"
#include "gb_modes.h"
#include "gb_vector.h"

enum { CLOSEST = 7 };             /* halvings of a quarter of a step, in search of a dip of a constraint force */
enum { POINTS = GB_EIGHTHS + 2 }; /* the start, one close to it, and the eighths */

static const double thetas[POINTS] = {0.0, 0.03125, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0};

/* A low sample between two higher ones: could the true minimum be below zero? */
static int may_dip(double before, double here, double after) {
    const double drop = gb_max(before, after) - here;
    return here <= before && here <= after && here < 0.5 * drop;
}

/* An event function that is armed on its limit and beyond it at b, by -fb: it may have moved inside first. Between 0
 * and b that is looked for ever closer to the start; the root is the return, or 0 where it was never inside. */
static int return_root(gb_sim *sim, int i, double side, double b, double fb, double tolerance, double *root) {
    const double rounding = gb_limit_rounding(sim, i, 0.0);
    int code = GB_DONE;
    *root = 0.0;
    for (double a = 0.0625 * b; fb < -rounding && a > tolerance && code == GB_DONE; a *= 0.0625) {
        code = gb_event_functions_at(sim, a, sim->events.s);
        const double fa = gb_limit_distance(sim, i, side, sim->events.s[i]);
        if (code == GB_DONE && fa > rounding) {
            return gb_true_root(sim, i, side, a, b, fa, fb, tolerance, root);
        }
        b = a;
        fb = fa;
    }
    return code;
}

/* The lowest point may lie between an end of the step and the sample next to it: where the end, at `low`, has the lower
 * value (f, at `next` it is `other`), the slope there tells. The root is between `low` and `next`, or stays 2. */
static int end_dip(gb_sim *sim, int i, double side, double low, double next, double f, double other, double tolerance,
                   double *root) {
    if (f < 0.0 || !(f < 0.5 * (other - f))) {
        return GB_DONE;
    }
    const double inside = low + 1e-3 * (next - low);
    int code = gb_event_functions_at(sim, inside, sim->events.s);
    const double there = gb_limit_distance(sim, i, side, sim->events.s[i]);
    if (code != GB_DONE || there >= f) {
        return code;
    }
    double x, value;
    code = gb_true_dip(sim, i, side, gb_min(low, next), inside, gb_max(low, next), there, &x, &value);
    if (code == GB_DONE && value < 0.0) {
        const double a = gb_min(low, next), fa = low < next ? f : other;
        code = gb_true_root(sim, i, side, a, x, fa, value, tolerance, root);
    }
    return code;
}

/* Does a constraint force reach its bound between samples at a, m and b that are far apart beside what its bounds do?
 * Looks closer until what bends is small beside the distance to the bound. */
static int look_closer(gb_sim *sim, int i, double side, double a, double b, const double *f, double bend, int depth,
                       double tolerance, double *first) {
    const double least = gb_min(gb_min(f[0], f[1]), f[2]), most = gb_max(gb_max(f[0], f[1]), f[2]);
    const double rough = gb_max(fabs(f[0] - 2.0 * f[1] + f[2]), bend), width = 0.25 * (b - a);
    if (depth == 0 || rough <= 0.5 * least || rough <= 1e-9 * most) {
        return GB_DONE;
    }
    double at[5] = {f[0], 0.0, f[1], 0.0, f[2]};
    for (int q = 1; q < 4; q += 2) {
        const int code = gb_event_functions_at(sim, a + q * width, sim->events.s);
        at[q] = gb_limit_distance(sim, i, side, sim->events.s[i]);
        if (code != GB_DONE || at[q] < 0.0) {
            const double x = a + (q - 1) * width;
            return code != GB_DONE ? code
                                   : gb_true_root(sim, i, side, x, x + width, at[q - 1], at[q], tolerance, first);
        }
    }
    const double off = fabs(at[1] - (0.375 * f[0] + 0.75 * f[1] - 0.125 * f[2]));
    for (int half = 0; half < 2 && *first > 1.0; half++) {
        const double from = a + 2.0 * half * width;
        const int code =
            look_closer(sim, i, side, from, from + 2.0 * width, at + 2 * half, 0.25 * off, depth - 1, tolerance, first);
        if (code != GB_DONE) {
            return code;
        }
    }
    return GB_DONE;
}

/* The quarters of the step before *first for a constraint force. */
static int look_at_force(gb_sim *sim, int i, double side, const double *f, double tolerance, double *first) {
    /* how far the sample at 1/32 lies off the parabola through those at 0, 1/8 and 1/4: samples alone could all be
     * equal */
    const double bend = fabs(f[1] - (21.0 * f[0] + 14.0 * f[2] - 3.0 * f[3]) / 32.0);
    for (int l = 0; l < 4 && 0.25 * (l + 1) <= *first; l++) {
        double earlier = 2.0;
        const double three[3] = {l == 0 ? f[0] : f[2 * l + 1], f[2 * l + 2], f[2 * l + 3]};
        const int code =
            look_closer(sim, i, side, 0.25 * l, 0.25 * l + 0.25, three, bend, CLOSEST, tolerance, &earlier);
        if (code != GB_DONE || earlier <= 1.0) {
            *first = gb_min(*first, earlier);
            return code;
        }
    }
    return GB_DONE;
}

/* Distances from the limit at the samples. */
static void sampled_distances(const gb_sim *sim, int i, double side, double *f) {
    const size_t n = (size_t)sim->model->n_event_functions;
    for (int l = 0; l < POINTS; l++) {
        f[l] = gb_limit_distance(sim, i, side, sim->events.samples[(size_t)l * n + (size_t)i]);
    }
}

/* The slip of a constraint that is one of speeds (that of a tie is a force). Slips are as smooth as the states; near
 * zero their samples differ by the rounding of speeds, which tells nothing of what they do between. */
static int is_slip(const gb_sim *sim, int i) {
    const int constraint = sim->events.slip_of[i];
    return constraint >= 0 && sim->model->constraints[constraint].kind != GB_TIE;
}

/* The force of an active constraint, which no later look takes for noise. */
static int is_force(const gb_sim *sim, int i) {
    return sim->events.role[i] == GB_CONSTRAINED && sim->events.lo[i] <= -HUGE_VAL && sim->events.slack[i] < 0.0 &&
           !is_slip(sim, i);
}

/* Where one constraint force is known to leave, another one that leaves later is of no interest: no root of event
 * function i is looked for that lies beyond `until`, where event functions are events.until. */
static int is_later(const gb_sim *sim, int i, double side, double from, double until) {
    return is_force(sim, i) && until <= 1.0 &&
           (from >= until || gb_limit_distance(sim, i, side, sim->events.until[i]) >= 0.0);
}

/* When event function i leaves through its limit `side`, by its samples. */
static int first_seen(gb_sim *sim, int i, double side, double until, double tolerance, double *first) {
    double f[POINTS];
    *first = 2.0;
    if (fabs(side < 0.0 ? sim->events.lo[i] : sim->events.hi[i]) >= HUGE_VAL) {
        return GB_DONE;
    }
    sampled_distances(sim, i, side, f);
    const int armed = f[0] == 0.0;
    const double rounding = gb_limit_rounding(sim, i, 0.0);
    if (!armed) {
        const int code = end_dip(sim, i, side, 0.0, thetas[1], f[0], f[1], tolerance, first);
        if (code != GB_DONE || *first <= 1.0) {
            return code;
        }
    }
    for (int l = 1; l < POINTS; l++) {
        if (f[l] < (armed ? -rounding : 0.0)) {
            if (is_later(sim, i, side, thetas[l - 1], until)) {
                *first = until;
                return GB_DONE;
            }
            if (armed && l == 1) {
                return return_root(sim, i, side, thetas[l], f[l], tolerance, first);
            }
            return gb_true_root(sim, i, side, thetas[l - 1], thetas[l], gb_max(f[l - 1], 0.0), f[l], tolerance, first);
        }
        if (l + 1 < POINTS && f[l + 1] >= 0.0 && !(armed && l == 1) && may_dip(f[l - 1], f[l], f[l + 1])) {
            double x, value;
            const int code = gb_true_dip(sim, i, side, thetas[l - 1], thetas[l], thetas[l + 1], f[l], &x, &value);
            if (code != GB_DONE || value < 0.0) {
                const double a = x > thetas[l] ? thetas[l] : thetas[l - 1];
                const double fa = x > thetas[l] ? f[l] : f[l - 1];
                return code != GB_DONE ? code : gb_true_root(sim, i, side, a, x, fa, value, tolerance, first);
            }
        }
    }
    return until <= thetas[POINTS - 2] && is_force(sim, i)
               ? GB_DONE
               : end_dip(sim, i, side, 1.0, thetas[POINTS - 2], f[POINTS - 1], f[POINTS - 2], tolerance, first);
}

/* The same; of a constraint force also between samples. */
static int first_through(gb_sim *sim, int i, double side, double until, double tolerance, double *first) {
    double f[POINTS];
    const int code = first_seen(sim, i, side, until, tolerance, first);
    const double limit = side < 0.0 && sim->events.slack[i] < 0.0 ? -HUGE_VAL
                         : side < 0.0                             ? sim->events.lo[i]
                                                                  : sim->events.hi[i];
    if (code != GB_DONE || sim->events.role[i] != GB_CONSTRAINED || fabs(limit) >= HUGE_VAL || is_slip(sim, i)) {
        return code;
    }
    sampled_distances(sim, i, side, f);
    return f[0] > 0.0 ? look_at_force(sim, i, side, f, tolerance, first) : code;
}

/* What is noise of the force of constraint i over the step: of its start or its end, whichever carries more. Where the
 * load comes to zero rounding does too, while that of the samples before does not. */
static double noise_over_step(gb_sim *sim, int i) {
    const double *time_terms = sim->lanes.time_terms;
    double force;
    return gb_max(gb_force_noise(sim, i, time_terms, sim->y0, &force),
                  gb_force_noise(sim, i, time_terms + sim->method->stages, sim->z, &force));
}

/* The step is so long that the samples do not tell what the force of an active constraint does (switch i), which could
 * reach its bound: what bends between samples is no small part of what changes at all. A train at rest has no other
 * reason for its steps. */
static int is_untold(gb_sim *sim, int i) {
    double least = HUGE_VAL, most = -HUGE_VAL, bend = 0.0, f[POINTS];
    sampled_distances(sim, i, 1.0, f);
    for (int l = 0; l < POINTS; l++) {
        least = gb_min(least, f[l]);
        most = gb_max(most, f[l]);
    }
    for (int l = 3; l + 1 < POINTS; l++) {
        bend = gb_max(bend, fabs((l == 3 ? f[2] : f[l - 1]) - 2.0 * f[l] + f[l + 1]));
    }
    const double start = fabs(f[1] - (21.0 * f[0] + 14.0 * f[2] - 3.0 * f[3]) / 32.0);
    const double range = gb_max(most - least, start);
    return least < 2.0 * range && gb_max(bend, 4.0 * start) > 0.3 * range && range > noise_over_step(sim, i);
}

/* It has a limit, and no enclosure. */
static int is_sampled(const gb_sim *sim, int i) {
    const int enclosed = sim->model->n_arguments > 0 && sim->panel.watched[i];
    return !enclosed && (sim->events.lo[i] > -HUGE_VAL || sim->events.hi[i] < HUGE_VAL);
}

/* The constraint force that leaves first, by chords between its samples; -1: none does. */
static int first_force(const gb_sim *sim) {
    double f[POINTS], soonest = 2.0;
    int first = -1;
    for (int i = sim->model->n_affine; i < sim->model->n_event_functions; i++) {
        int l = 1;
        if (is_sampled(sim, i) && is_force(sim, i)) {
            sampled_distances(sim, i, 1.0, f);
            while (l < POINTS && f[l] >= 0.0) {
                l++;
            }
            const double part = l < POINTS && f[l - 1] > 0.0 ? f[l - 1] / (f[l - 1] - f[l]) : 0.0;
            const double at = l < POINTS ? thetas[l - 1] + part * (thetas[l] - thetas[l - 1]) : 2.0;
            first = at < soonest ? i : first;
            soonest = gb_min(soonest, at);
        }
    }
    return first;
}

/* What leaves before the first event that is known, at `cut`, though it is inside at the next sample: laws do not hold
 * beyond an event (a capacity that has faded). */
static int first_before(gb_sim *sim, int i, double side, double cut, double tolerance, double *first) {
    double f[POINTS];
    int l = POINTS - 1;
    if (*first <= cut || fabs(side < 0.0 ? sim->events.lo[i] : sim->events.hi[i]) >= HUGE_VAL) {
        return GB_DONE;
    }
    sampled_distances(sim, i, side, f);
    while (l > 0 && thetas[l] >= cut) {
        l--;
    }
    const double end = gb_limit_distance(
        sim, i, side, sim->events.samples[(size_t)POINTS * (size_t)sim->model->n_event_functions + (size_t)i]);
    return f[l] > 0.0 && end < -gb_limit_rounding(sim, i, 0.0)
               ? gb_true_root(sim, i, side, thetas[l], cut, f[l], end, tolerance, first)
               : GB_DONE;
}

/* When event function i leaves its mode; `until`: a little after the first constraint force that does. */
static int locate_one(gb_sim *sim, int i, double cut, double tolerance, double *until) {
    double low = 2.0, high = 2.0;
    int code = first_through(sim, i, -1.0, *until, tolerance, &low);
    code = code == GB_DONE ? first_through(sim, i, 1.0, *until, tolerance, &high) : code;
    if (cut < 1.0) {
        code = code == GB_DONE ? first_before(sim, i, -1.0, cut, tolerance, &low) : code;
        code = code == GB_DONE ? first_before(sim, i, 1.0, cut, tolerance, &high) : code;
    }
    sim->events.located[i] = gb_min(low, high) < *until ? gb_min(low, high) : 2.0;
    sim->events.side[i] = low < high ? -1.0 : 1.0;
    if (is_force(sim, i) && sim->events.hi[i] == 0.0 && !sim->events.undersampled && is_untold(sim, i)) {
        sim->events.undersampled = i + 1;
    }
    if (code == GB_DONE && is_force(sim, i) && sim->events.located[i] <= 1.0 &&
        sim->events.located[i] + tolerance < *until) {
        *until = sim->events.located[i] + tolerance;
        code = gb_event_functions_at(sim, *until, sim->events.until);
    }
    return code;
}

int gb_locate_sampled(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int n = model->n_event_functions;
    const double tolerance = gb_rounding(sim->head->front.t0, sim->head->front.h) / sim->head->front.h;
    double until = 2.0, cut = 2.0;
    int code = GB_DONE, any = 0;
    for (int i = 0; i < n; i++) {
        if (i >= model->n_affine && !(model->n_arguments > 0 && sim->panel.watched[i])) {
            any = any || is_sampled(sim, i);
            sim->events.located[i] = 2.0;
        }
        cut = gb_min(cut, sim->events.located[i]);
    }
    if (!any) {
        return GB_DONE;
    }
    code = gb_dense_complete(sim);
    memcpy(sim->events.samples, sim->events.s0, sizeof(double) * (size_t)n);
    for (int l = 1; l < POINTS && code == GB_DONE; l++) {
        code = gb_event_functions_at(sim, thetas[l], sim->events.samples + (size_t)l * (size_t)n);
    }
    code = code == GB_DONE && cut < 1.0
               ? gb_event_functions_at(sim, cut, sim->events.samples + (size_t)POINTS * (size_t)n)
               : code;
    const int first = code == GB_DONE ? first_force(sim) : -1;
    code = first >= 0 ? locate_one(sim, first, cut, tolerance, &until) : code;
    for (int i = model->n_affine; i < n && code == GB_DONE; i++) {
        if (i != first && is_sampled(sim, i)) {
            code = locate_one(sim, i, cut, tolerance, &until);
        }
    }
    return code;
}
