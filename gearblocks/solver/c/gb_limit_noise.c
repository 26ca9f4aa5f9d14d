#include "gb_limit_noise.h"
#include "gb_values_for.h"
#include "gb_vector.h"

/* Most of sum |ds/dy_j| over any event function: what is farther from its limit is not looked at closely. */
static const double STEEPEST = 1e6;

/* What forces leave of a speed that is held, in parts of the largest speed. */
static const double ROUNDING = 4096.0 * DBL_EPSILON;

/* y with every state in [from, to) moved by another part of `size`: parts that no law of a train knows. */
static void move(double *moved, int from, int to, double size) {
    for (int j = from; j < to; j++) {
        const double part = 0.6180339887498949 * (double)(j + 1);
        moved[j] += size * (0.5 + part - floor(part));
    }
}

/* Event function i lies within the rounding of the largest speed of its limit, and reads no state but the speeds, of
 * these only what active constraints hold: speeds that are moved at random move it, but not once the slips of active
 * constraints are taken away. */
static int is_held(gb_sim *sim, int i, double distance, const double *time_terms, const double *y) {
    const gb_model *model = sim->model;
    const int speeds = model->n - model->n_speeds;
    double *s = sim->events.moved, *moved = sim->z2, size = 0.0;
    for (int j = speeds; j < model->n; j++) {
        size = gb_max(size, fabs(y[j]));
    }
    if (size == 0.0 || model->n_constraints == 0 || sim->mode[model->n_switches] == 0.0) {
        return 0;
    }
    gb_values_for(sim, i, time_terms, y, s);
    const double here = s[i];
    memcpy(moved, y, sizeof(double) * (size_t)model->n_total);
    move(moved, 0, speeds, size);
    gb_values_for(sim, i, time_terms, moved, s);
    if (s[i] != here) {
        return 0;
    }
    memcpy(moved, y, sizeof(double) * (size_t)model->n_total);
    move(moved, speeds, model->n, size);
    gb_values_for(sim, i, time_terms, moved, s);
    const double free = fabs(s[i] - here);
    model->project_velocities(sim->par, sim->mode, time_terms, moved);
    gb_values_for(sim, i, time_terms, moved, s);
    return fabs(distance) <= ROUNDING * free && fabs(s[i] - here) < 1e-9 * free;
}

double gb_beyond_noise(const gb_sim *sim, const double *y, const double *other) {
    double largest = 0.0, noise = 0.0;
    for (int j = 0; j < sim->model->n; j++) {
        largest = gb_max(largest, gb_max(fabs(y[j]), fabs(other[j])));
        noise = gb_max(noise, sim->control.noise[j]);
    }
    return STEEPEST * gb_max(64.0 * DBL_EPSILON * largest, sim->head->front.h * noise);
}

int gb_is_far(const gb_sim *sim, double distance, const double *y, const double *other) {
    return fabs(distance) > gb_beyond_noise(sim, y, other);
}

int gb_is_noise(gb_sim *sim, int i, double distance, const double *time_terms, const double *y, const double *other) {
    const gb_model *model = sim->model;
    double noise = 0.0, *s = sim->events.moved, *moved = sim->z2;
    if (gb_is_far(sim, distance, y, other)) {
        return 0;
    }
    if (fabs(distance) <= DBL_MIN) { /* what has faded so far has no digits left */
        return 1;
    }
    gb_values_for(sim, i, time_terms, y, s);
    const double here = s[i];
    memcpy(moved, y, sizeof(double) * (size_t)model->n_total);
    for (int j = 0; j < model->n; j++) {
        const double size = gb_max(fabs(y[j]), fabs(other[j]));
        if (size > 0.0) {
            moved[j] = y[j] + 1e-6 * size;
            gb_values_for(sim, i, time_terms, moved, s);
            noise += 64e6 * DBL_EPSILON * fabs(s[i] - here);
            moved[j] = y[j];
        }
    }
    return fabs(distance) <= noise || is_held(sim, i, distance, time_terms, y);
}

/* State j has been no larger than what the noise of its rate may have made it in the run so far: fast laws have noisy
 * rates, and what is no noise of a motion is none of a switch either. */
static int has_not_moved(const gb_sim *sim, int j) {
    const double elapsed = sim->head->front.t0 + sim->head->front.h - sim->head->front.t_start;
    return sim->control.largest[j] <= elapsed * sim->control.noise[j];
}

int gb_is_noise_of_rates(gb_sim *sim, int i, double distance, const double *time_terms, const double *y) {
    const gb_model *model = sim->model;
    double noise = 0.0, *s = sim->events.moved, *moved = sim->z2;
    gb_values_for(sim, i, time_terms, y, s);
    const double here = s[i];
    memcpy(moved, y, sizeof(double) * (size_t)model->n_total);
    for (int j = 0; j < model->n; j++) {
        moved[j] = y[j] + sim->head->front.h * sim->control.noise[j];
        if (moved[j] != y[j] && has_not_moved(sim, j)) {
            gb_values_for(sim, i, time_terms, moved, s);
            noise += fabs(s[i] - here);
        }
        moved[j] = y[j];
    }
    return fabs(distance) <= noise;
}
