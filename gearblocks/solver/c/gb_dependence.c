#include "gb_dependence.h"
#include "gb_constraint_state.h"
#include "gb_modes.h"
#include "gb_rates.h"
#include "gb_turned_gears.h"
#include "gb_vector.h"

static const double SAME = 1e-12; /* of the terms of a difference: what is left of it is nothing */

/* The constraint by whose force event function i is active: friction or a stop; else -1. */
static int holding(const gb_sim *sim, int i) {
    const int c = sim->events.force_of[i];
    const int kind = c >= 0 ? (int)sim->model->constraints[c].kind : -1;
    return (kind == GB_FRICTION || kind == GB_STOP) && gb_is_active(sim, c) ? c : -1;
}

/* Event function i tells of what rests on a limit: its force, and that of the tie of a lossy gear. */
static int is_of_rest(const gb_sim *sim, int i) {
    int found = 0;
    for (int j = 0; j < sim->head->events.n_sliding; j++) {
        const int c = sim->head->events.resting[j];
        const gb_constraint *of = c >= 0 ? sim->model->constraints + c : NULL;
        found |= of && (i == of->active || (of->kind == GB_LOSS && i == sim->model->constraints[of->partner].slip));
    }
    return found;
}

/* Constraint forces by the mean of both sides, into constraints.peak, and their bounds; returns the largest of the
 * terms of which any is made: rounding goes on from one to the next. */
static double mean_forces(gb_sim *sim, const double *y, const double *share) {
    const gb_model *model = sim->model;
    struct gb_constraints *c = &sim->constraints;
    double *below = c->lo, *above = c->hi, *mean = c->peak, largest = 0.0;
    model->force_bounds(sim->par, sim->mode, sim->instant.time_terms, y, c->bounds);
    model->constraint_forces(sim->par, sim->mode, sim->instant.time_terms, y, below, c->right);
    memcpy(mean, below, sizeof(double) * (size_t)model->n_constraints);
    for (int j = 0; j < sim->head->events.n_sliding; j++) {
        gb_set_above(sim, 1 << j);
        const double *terms = gb_terms_above(sim, &sim->instant, 0);
        model->constraint_forces(sim->par, sim->sliding.mode, terms, y, above, c->right);
        for (int i = 0; i < model->n_constraints; i++) {
            mean[i] += share[j] * (above[i] - below[i]);
            largest = gb_max(largest, fabs(above[i]) + fabs(below[i]));
        }
    }
    return largest;
}

/* Event function i asks for the torque that slides: it differs between the sides, and is not of a condition that is in
 * its mode on both, or of a constraint that holds what the mean asks of it, and the lower sides, which are searched for
 * events. settles: what holds by the mean alone is not searched from here on. */
static int depends(gb_sim *sim, int i, double below, double above, double largest, int settles) {
    const gb_model *model = sim->model;
    const int constraint = holding(sim, i), same = fabs(above - below) <= SAME * (fabs(above) + fabs(below));
    if (is_of_rest(sim, i)) {
        return 0;
    }
    if (constraint >= 0) {
        const double *bounds = sim->constraints.bounds + 5 * constraint, mean = sim->constraints.peak[constraint];
        const double beyond = gb_max(mean - bounds[1], bounds[0] - mean), lower = below > SAME * largest ? below : 0.0;
        if (settles && constraint < 64 && lower > 0.0 && beyond <= 0.0) {
            sim->head->events.by_mean |= (uint64_t)1 << constraint;
        }
        return !same && gb_max(gb_holds_by_mean(sim, constraint) ? 0.0 : lower, beyond) > SAME * largest;
    }
    if (same) {
        return 0;
    }
    const int gear = gb_sign_of_gear(sim, i);
    if (gear >= 0 && sim->head->events.n_sliding == 1) {
        return !gb_sign_agrees(sim->sliding.mode[i], above, fabs(above) + fabs(below));
    }
    if (sim->events.role[i] == GB_SILENT && sim->mode[i] < 0.5 && below <= 0.0 && above <= 0.0) {
        return 0; /* of a capacity, with its sign turned: one of 0 on one side rubs with nothing there */
    }
    return sim->events.role[i] == GB_CONSTRAINED || gb_slides(sim, i) ||
           model->mode_at(sim->par, i, below) != sim->mode[i] || model->mode_at(sim->par, i, above) != sim->mode[i];
}

int gb_others_depend(gb_sim *sim, const double *y, const double *share, int settles) {
    const gb_model *model = sim->model;
    const int n = model->n_event_functions;
    const double largest = model->n_constraints > 0 ? mean_forces(sim, y, share) : 0.0;
    double *below = sim->sliding.functions, *above = below + n;
    model->event_functions(sim->par, sim->mode, sim->instant.time_terms, y, below);
    for (int which = 1; which < 1 << sim->head->events.n_sliding; which++) {
        gb_set_above(sim, which);
        const double *terms = gb_terms_above(sim, &sim->instant, 0);
        model->event_functions(sim->par, sim->sliding.mode, terms, y, above);
        for (int i = 0; i < n; i++) {
            if (depends(sim, i, below[i], above[i], largest, settles)) {
                return 1;
            }
        }
    }
    return 0;
}

int gb_slips_turn(gb_sim *sim, const double *share) {
    const gb_model *model = sim->model;
    struct gb_constraints *own = &sim->constraints;
    double *mean = own->peak;
    const double *rates = sim->sliding.rates;
    if (model->n_constraints == 0) {
        return 0;
    }
    model->slips(sim->par, sim->mode, sim->instant.time_terms, sim->y, rates, own->lo);
    memcpy(mean, own->lo, sizeof(double) * (size_t)model->n_constraints);
    for (int j = 0; j < sim->head->events.n_sliding; j++) {
        rates += model->n_total;
        model->slips(sim->par, sim->mode, sim->instant.time_terms, sim->y, rates, own->hi);
        for (int c = 0; c < model->n_constraints; c++) {
            mean[c] += share[j] * (own->hi[c] - own->lo[c]);
        }
    }
    for (int c = 0; c < model->n_constraints; c++) {
        const gb_constraint *of = &model->constraints[c];
        const int slides = (of->kind == GB_FRICTION || of->kind == GB_LOSS) && !gb_is_active(sim, c);
        if (slides && (gb_flips_at_front(sim, of->slip) || gb_flips_at_front(sim, of->active)) &&
            sim->mode[of->slip] * mean[c] < 0.0) {
            return 1;
        }
    }
    return 0;
}
