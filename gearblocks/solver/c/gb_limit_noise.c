#include "gb_limit_noise.h"
#include "gb_vector.h"

/* Most of sum |ds/dy_j| over any event function: what is farther from its limit is not looked at closely. */
static const double STEEPEST = 1e6;

int gb_is_noise(gb_sim *sim, int i, double distance, const double *time_terms, const double *y, const double *other) {
    const gb_model *model = sim->model;
    double largest = 0.0, noise = 0.0, *s = sim->events.moved, *moved = sim->z2;
    for (int j = 0; j < model->n; j++) {
        largest = gb_max(largest, gb_max(fabs(y[j]), fabs(other[j])));
    }
    if (fabs(distance) > 64.0 * DBL_EPSILON * STEEPEST * largest) {
        return 0;
    }
    model->event_functions(sim->par, sim->mode, time_terms, y, s);
    const double here = s[i];
    memcpy(moved, y, sizeof(double) * (size_t)model->n_total);
    for (int j = 0; j < model->n; j++) {
        const double size = gb_max(fabs(y[j]), fabs(other[j]));
        if (size > 0.0) {
            moved[j] = y[j] + 1e-6 * size;
            model->event_functions(sim->par, sim->mode, time_terms, moved, s);
            noise += 64e6 * DBL_EPSILON * fabs(s[i] - here);
            moved[j] = y[j];
        }
    }
    return fabs(distance) <= noise;
}
