#include "gb_locate.h"
#include "gb_constraint_state.h"
#include "gb_event_values.h"
#include "gb_force_enclosure.h"
#include "gb_force_noise.h"
#include "gb_limit_noise.h"
#include "gb_limit_stay.h"
#include "gb_locate_enclosed.h"
#include "gb_locate_polynomial.h"
#include "gb_locate_sampled.h"
#include "gb_modes.h"
#include "gb_vector.h"

/* Part of a step from which on its end is looked at for a bound that has come to a force of noise. */
static const double LAST = 1.0 - 1e-6;

/* Part of a step up to which what has just been decided comes back at once. */
static const double EARLY = 0.125;

/* Part of the rounding of a force that is rounding whatever it moves: a few units of the last place. */
static const double SURELY = 0.125;

/* Where in a step is looked whether a force that is none at both ends is none between: bounds and loads that pass zero
 * in turn do so at halves and quarters, and what has just reached its bound may be far inside it later on. */
static const double WITHIN[] = {0.001, 0.03125, 0.14, 0.382, 0.618, 0.86};

/* Event function i is no more than noise beyond its limit `side` between the ends of the step either. */
static int stays_within(gb_sim *sim, int i, double side, double noise) {
    const double limit = side < 0.0 ? sim->events.lo[i] : sim->events.hi[i];
    int stays = 1;
    for (size_t l = 0; l < sizeof WITHIN / sizeof WITHIN[0] && stays; l++) {
        stays = gb_event_functions_at(sim, WITHIN[l], sim->events.s) != GB_DONE ||
                side * (sim->events.s[i] - limit) < noise;
    }
    return stays;
}

/* The force of an active constraint, located in this step, is on its bound at both ends of it, and not beyond between,
 * but for what moves nothing: a contact whose damping eats up its spring leaves such a force to a freewheel behind it.
 * Where the force is more than that itself, only its rounding moves nothing: what is beyond the bound in each of many
 * short steps moves. So where a step is tried again with a part of its size: what moves nothing in the part was
 * something in the whole. Before anything has moved, its rounding alone tells. */
static int is_no_force(gb_sim *sim, int i, double start, const double *time_terms) {
    double force;
    const double rounding = gb_force_rounding(sim, i, time_terms, sim->z, &force);
    const double idle = gb_idle_force(sim, i, rounding, time_terms, sim->z);
    const double least = idle > 0.0 ? gb_min(idle, rounding) : rounding;
    const double noise = gb_max(SURELY * rounding, force < idle && !sim->events.again ? idle : least);
    if (!(fabs(start) < noise)) {
        return 0;
    }
    sim->model->event_functions(sim->par, sim->mode, time_terms, sim->z, sim->events.s);
    return fabs(sim->events.s[i] - sim->events.hi[i]) < noise && stays_within(sim, i, 1.0, noise);
}

/* The force of an active constraint, located right at the end of this step, is noise there, and so is what its bound
 * leaves: a capacity that fades to zero lets go of what loads it before, and of nothing else. */
static int fades_unloaded(gb_sim *sim, int i, const double *time_terms) {
    if (sim->events.located[i] < LAST) {
        return 0;
    }
    sim->model->event_functions(sim->par, sim->mode, time_terms, sim->z, sim->events.s);
    const double excess = fabs(sim->events.s[i] - sim->events.hi[i]);
    double force;
    const double noise = gb_force_noise(sim, i, time_terms, sim->z, &force);
    return excess < noise && force < noise;
}

/* Event function i is the gap of a stop that has just opened, and it has moved by noise; or it comes back as the step
 * begins, and over the step moves by no more than the rounding of speeds, as large as they have been. A body that a
 * stop has held leaves it with the third power of time once its force has passed zero, and what is left of its slip may
 * be directed back: for a while rounding tells on which side of the stop it is. */
static int opens_by_noise(gb_sim *sim, int i, const double *time_terms) {
    const int c = sim->events.slip_of[i];
    if (c < 0 || !gb_is_stop(sim, c) || sim->events.armed[i] != sim->events.side[i]) {
        return 0;
    }
    sim->model->event_functions(sim->par, sim->mode, time_terms, sim->z, sim->events.s);
    const double moved = sim->events.s[i] - sim->events.s0[i], speed = gb_largest_speed(sim, sim->control.largest);
    const double imperceptible = 64.0 * DBL_EPSILON * speed * sim->constraints.row_size[c] * sim->head->front.h;
    return (sim->events.located[i] < EARLY && fabs(moved) <= imperceptible) ||
           gb_is_noise(sim, i, moved, time_terms, sim->z, sim->y0);
}

/* `distance` is what rounding makes of event function i: that of the states, or of their rates over the step. */
static int is_near(gb_sim *sim, int i, double distance, const double *time_terms) {
    return !gb_is_far(sim, distance, sim->z, sim->y0) && (gb_is_noise(sim, i, distance, time_terms, sim->z, sim->y0) ||
                                                          gb_is_noise_of_rates(sim, i, distance, time_terms, sim->z));
}

/* Switch i, located in this step, has not left its limit from the start to the end but for noise. Most are plainly off
 * it at one of both. */
static int has_stayed(gb_sim *sim, int i) {
    const double *time_terms = sim->lanes.time_terms + sim->method->stages;
    const double limit = sim->events.side[i] < 0.0 ? sim->events.lo[i] : sim->events.hi[i];
    const double start = sim->events.s0[i] - limit;
    if (sim->events.role[i] == GB_CONSTRAINED) {
        return is_no_force(sim, i, start, time_terms) || fades_unloaded(sim, i, time_terms) ||
               opens_by_noise(sim, i, time_terms);
    }
    if (gb_is_far(sim, start, sim->z, sim->y0)) {
        return 0;
    }
    sim->model->event_functions(sim->par, sim->mode, time_terms, sim->z, sim->events.s);
    const double end = sim->events.s[i] - limit;
    if (is_near(sim, i, end, time_terms) && is_near(sim, i, start, time_terms)) {
        return 1;
    }
    const double idle = gb_swings_idly(sim, i, gb_max(fabs(start), fabs(end)));
    return idle > 0.0 && stays_within(sim, i, sim->events.side[i], idle);
}

/* A slip that has just let go in the direction of its acceleration, or a switch that flips for the second time without
 * progress, and yet comes back in the first eighth of the step, or there a constraint force that has been found inside
 * its bounds at this instant, once more: the error of the polynomial may do that, a shorter step tells, as long as it
 * can be told from rounding. */
static int comes_back_early(const gb_sim *sim, int i) {
    const double h = sim->head->front.h;
    const int constrained = sim->events.role[i] == GB_CONSTRAINED, again = sim->events.flips[i] > 1.0;
    const int armed = sim->events.armed[i] == sim->events.side[i];
    return h > 1e6 * gb_rounding(sim->head->front.t0, h) && sim->events.located[i] < EARLY &&
           (armed ? constrained || again : constrained && again);
}

/* What was located in [from, to) and is noise is no event: its limit is not watched in this step. The search of other
 * functions ends at the first event that is known, so that noise has to go first. Returns how many there were. */
static int drop_noise(gb_sim *sim, int from, int to) {
    int dropped = 0;
    for (int i = from; i < to; i++) {
        if (sim->events.located[i] <= 1.0 && has_stayed(sim, i)) {
            sim->events.located[i] = 2.0;
            *(sim->events.side[i] < 0.0 ? &sim->events.lo[i] : &sim->events.hi[i]) = sim->events.side[i] * HUGE_VAL;
            dropped++;
        }
    }
    return dropped;
}

/* What forces of lossy gears may go beyond zero, as slip acceleration: what changes speeds by no more than their
 * rounding within the step. Both sides of zero ask for the same motion there. */
static void measure_slack(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_constraints; i++) {
        if (model->constraints[i].kind == GB_TIE) {
            const double speed = gb_largest_speed(sim, sim->y0);
            sim->events.slack[model->constraints[i].slip] =
                64.0 * DBL_EPSILON * speed * sim->constraints.row_size[i] / sim->head->front.h;
        }
    }
}

/* The event functions that are not affine, once more where the search ended at noise. */
static int watch_others(gb_sim *sim, int *noisy) {
    const gb_model *model = sim->model;
    int code = GB_DONE, dropped = 1;
    measure_slack(sim);
    while (code == GB_DONE && dropped > 0) {
        code = model->n_arguments > 0 ? gb_locate_enclosed(sim) : GB_DONE;
        code = code == GB_DONE ? gb_locate_sampled(sim) : code;
        dropped = code == GB_DONE ? drop_noise(sim, model->n_affine, model->n_event_functions) : 0;
        *noisy += dropped;
    }
    return code;
}

/* The first theta of all that was located; and whether it is in doubt. */
static double look_again(gb_sim *sim) {
    double first = 2.0;
    for (int i = 0; i < sim->model->n_event_functions; i++) {
        if (sim->events.located[i] <= 1.0) {
            sim->events.in_doubt = comes_back_early(sim, i) ? i + 1 : sim->events.in_doubt;
            first = gb_min(first, sim->events.located[i]);
        }
    }
    return first;
}

int gb_locate(gb_sim *sim, double *theta) {
    const gb_model *model = sim->model;
    const double tolerance = gb_rounding(sim->head->front.t0, sim->head->front.h) / sim->head->front.h;
    double first = 2.0;
    int code = GB_DONE, noisy = 0;
    sim->events.undersampled = sim->events.in_doubt = 0;
    if (model->n_constraints > 0 && !sim->head->events.armed && gb_forces_stay(sim)) {
        *theta = first;
        return GB_DONE;
    }
    model->event_functions(sim->par, sim->mode, sim->lanes.time_terms, sim->y0, sim->events.s0);
    if (model->n_affine > 0) {
        code = gb_locate_affine(sim, tolerance);
        noisy = code == GB_DONE ? drop_noise(sim, 0, model->n_affine) : 0;
    }
    if (code == GB_DONE && model->n_event_functions > model->n_affine) {
        code = watch_others(sim, &noisy);
    }
    if (noisy > 0) { /* with those that were not watched */
        gb_mode_limits(sim);
    }
    if (code == GB_DONE) {
        first = look_again(sim);
    }
    if (first <= 1.0) {
        const double last = gb_min(first + tolerance, 1.0); /* steps may be shorter than time is told */
        for (int i = 0; i < model->n_event_functions; i++) {
            sim->events.pending[i] = sim->events.located[i] <= last ? sim->events.side[i] : 0.0;
        }
    }
    *theta = first;
    return code;
}
