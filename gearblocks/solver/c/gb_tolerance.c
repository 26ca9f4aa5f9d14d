#include "gb_tolerance.h"
#include "gb_values_for.h"

/* The tolerance of state j; 0 where it has none (never moved, or steps are prescribed). */
static double tolerance(const gb_sim *sim, int j) {
    const double weight = sim->control.error_weight[j];
    return weight > 0.0 ? 1.0 / weight : 0.0;
}

enum { ALL, SMALL, FADED };

/* Adds what the tolerances of the states admit for the event functions [first, first + count), events.s at y; of all
 * states, of those that are small beside what counts as a size for them, or that have faded below their tolerance. */
static void add_tolerances(gb_sim *sim, int first, int count, int which, const double *time_terms, const double *y,
                           double *sum) {
    const gb_model *model = sim->model;
    const double rtol = sim->head->options.rtol;
    double *moved = sim->events.moved, *changed = sim->z2;
    memcpy(changed, y, sizeof(double) * (size_t)model->n_total);
    for (int j = 0; j < model->n; j++) {
        const double size = tolerance(sim, j);
        const int counts = which == SMALL   ? 2.0 * sim->control.largest[j] * rtol < size
                           : which == FADED ? fabs(y[j]) <= size
                                            : 1;
        if (size > 0.0 && counts) {
            changed[j] += size;
            gb_values_for(sim, first + count - 1, time_terms, changed, moved);
            for (int i = 0; i < count; i++) {
                sum[i] += fabs(moved[first + i] - sim->events.s[first + i]);
            }
            changed[j] = y[j];
        }
    }
}

double gb_tolerance_of(gb_sim *sim, int i) {
    double sum = 0.0;
    add_tolerances(sim, i, 1, ALL, sim->instant.time_terms, sim->y, &sum);
    return sum;
}

double gb_tolerance_at(gb_sim *sim, int i, const double *time_terms, const double *y) {
    double sum = 0.0;
    add_tolerances(sim, i, 1, FADED, time_terms, y, &sum);
    return sum;
}

void gb_tolerances_of_small(gb_sim *sim, double *sum) {
    memset(sum, 0, sizeof(double) * (size_t)sim->model->n_event_functions);
    add_tolerances(sim, 0, sim->model->n_event_functions, SMALL, sim->instant.time_terms, sim->y, sum);
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
