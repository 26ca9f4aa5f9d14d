#include "gb_tolerance.h"

/* The tolerance of state j; 0 where it has none (never moved, or steps are prescribed). */
static double tolerance(const gb_sim *sim, int j) {
    const double weight = sim->control.error_weight[j];
    return weight > 0.0 ? 1.0 / weight : 0.0;
}

double gb_tolerance_of(gb_sim *sim, int i, int small_alone) {
    const gb_model *model = sim->model;
    const double here = sim->events.s[i], rtol = sim->head->options.rtol;
    double *moved = sim->events.moved, *y = sim->z2, sum = 0.0;
    memcpy(y, sim->y, sizeof(double) * (size_t)model->n_total);
    for (int j = 0; j < model->n; j++) {
        const double size = tolerance(sim, j);
        if (size > 0.0 && (!small_alone || 2.0 * sim->control.largest[j] * rtol < size)) {
            y[j] += size;
            model->event_functions(sim->par, sim->mode, sim->instant.time_terms, y, moved);
            sum += fabs(moved[i] - here);
            y[j] = sim->y[j];
        }
    }
    return sum;
}

double gb_tolerance_of_slip(gb_sim *sim, int i) {
    const gb_model *model = sim->model;
    double *slip = sim->constraints.free_acceleration, *y = sim->z2, sum = 0.0;
    memcpy(y, sim->y, sizeof(double) * (size_t)model->n_total);
    for (int j = model->n - model->n_speeds; j < model->n; j++) {
        const double size = tolerance(sim, j);
        if (size > 0.0) {
            y[j] += size;
            model->slips(sim->par, sim->mode, sim->instant.time_terms, y, NULL, slip);
            sum += fabs(slip[i] - sim->constraints.slip[i]);
            y[j] = sim->y[j];
        }
    }
    return sum;
}
