#include "gb_force_noise.h"
#include "gb_constraint_state.h"
#include "gb_constraints.h"
#include "gb_vector.h"

/* The slip acceleration of constraint i that in the step at hand moves speeds, as large as they have been, by less than
 * their rounding. */
static double imperceptible(const gb_sim *sim, int i) {
    const double speed = gb_largest_speed(sim, sim->control.largest);
    return sim->head->front.h > 0.0 ? speed * sim->constraints.row_size[i] / sim->head->front.h : 0.0;
}

/* The active constraint whose excess event function i tells, or -1. */
static int constraint_of(const gb_sim *sim, int i) {
    const int constraint = sim->events.force_of[i];
    return constraint >= 0 && gb_is_active(sim, constraint) ? constraint : -1;
}

/* Speeds, as large as they have been, are no more than what rounding of the force of constraint i, as slip
 * acceleration, makes of them in the time that has passed: nothing has moved yet. */
static int nothing_moved(const gb_sim *sim, int i, double acceleration) {
    const struct gb_front *front = &sim->head->front;
    const double speed = gb_largest_speed(sim, sim->control.largest);
    return speed * sim->constraints.row_size[i] <= acceleration * (front->t1 - front->t_start);
}

double gb_idle_force(gb_sim *sim, int i, double rounding, const double *time_terms, const double *y) {
    const gb_delassus W = gb_delassus_of(sim);
    const int constraint = constraint_of(sim, i);
    if (constraint < 0) {
        return 0.0;
    }
    sim->model->delassus(sim->par, sim->mode, time_terms, y, 0, sim->constraints.delassus);
    const double own = gb_delassus_diagonal(&W, constraint);
    if (nothing_moved(sim, constraint, rounding * own)) {
        return 0.0;
    }
    return own > 0.0 ? 64.0 * DBL_EPSILON * imperceptible(sim, constraint) / own : 0.0;
}

double gb_force_rounding(gb_sim *sim, int i, const double *time_terms, const double *y, double *force) {
    const gb_model *model = sim->model;
    const gb_delassus W = gb_delassus_of(sim);
    const int constraint = constraint_of(sim, i);
    double largest = 0.0;
    *force = 0.0;
    if (constraint < 0) {
        return 0.0;
    }
    model->constraint_forces(sim->par, sim->mode, time_terms, y, sim->constraints.other, sim->constraints.right);
    model->delassus(sim->par, sim->mode, time_terms, y, 0, sim->constraints.delassus);
    for (int j = 0; j < W.n; j++) { /* rounding of one force goes on through those between it and another one */
        double terms = 0.0;
        gb_delassus_product(&W, j, sim->constraints.other, &terms);
        largest = gb_is_active(sim, j) ? gb_max(largest, terms) : largest;
    }
    const double own = gb_delassus_diagonal(&W, constraint);
    *force = fabs(sim->constraints.other[constraint]);
    return own > 0.0 ? 64.0 * DBL_EPSILON * largest / own : 0.0;
}

double gb_force_noise(gb_sim *sim, int i, const double *time_terms, const double *y, double *force) {
    const double rounding = gb_force_rounding(sim, i, time_terms, y, force);
    return gb_max(rounding, gb_idle_force(sim, i, rounding, time_terms, y));
}
