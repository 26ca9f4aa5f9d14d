#include "gb_noise.h"
#include "gb_constraint_forces.h"
#include "gb_rates.h"
#include "gb_rosenbrock.h"
#include "gb_vector.h"

/* Rounding of the acceleration of what locks hold, in parts of the one that it had without them. */
static const double OF_LOCKS = 256.0 * DBL_EPSILON;

int gb_noise_of_locks(gb_sim *sim, const gb_lanes *at, double *left) {
    const gb_model *model = sim->model;
    const double gain = sim->method->gamma > 0.0 ? (double)(1u << sim->head->control.doublings) : 1.0;
    int beyond = 0;
    gb_free_rates(sim, at->time_terms + sim->method->stages, sim->z, left);
    for (int i = 0; i < model->n; i++) {
        const double noise = i < model->n - model->n_speeds ? 0.0 : OF_LOCKS * gain * fabs(left[i]);
        left[i] = noise < HUGE_VAL ? noise : 0.0;
        beyond |= left[i] > sim->control.noise[i];
    }
    return beyond;
}

/* The sign with which state i is moved in the n-th measurement of noise (a row of a Walsh matrix): what two balanced
 * forces make of their states' bits cancels in every other one. */
static int is_raised(int i, unsigned n) {
    unsigned bits = (unsigned)i & (n * 0x9E3779B1u);
    bits ^= bits >> 16, bits ^= bits >> 8, bits ^= bits >> 4;
    return (0x6996 >> (bits & 15u) & 1) == 0;
}

/* Rates at y0, time moved by its last bits: what its rounding makes of them. Inputs stay. */
static void rates_after(gb_sim *sim, const gb_lanes *at, double *rate) {
    gb_lanes *own = &sim->sliding.lanes;
    for (int l = 0; l < GB_LANES; l++) {
        own->t[l] = at->t[0] + 2.0 * DBL_EPSILON * fabs(at->t[0]);
        for (int i = 0; i < sim->model->n_inputs; i++) {
            own->u[i * GB_LANES + l] = at->u[i * GB_LANES];
        }
    }
    sim->model->time_terms(sim->par, sim->mode, 1, own->t, own->u, own->time_terms);
    gb_rates(sim, 0, own, 0, sim->y0, rate);
    sim->head->counts.rhs_calls++;
}

/* Adds to the noise by how far these rates are from those that are known. */
static void add_noise(gb_sim *sim, double *rate, double gain) {
    for (int i = 0; i < sim->model->n; i++) {
        rate[i] -= sim->k1[i];
    }
    if (sim->method->gamma > 0.0) {
        gb_rosenbrock_response(sim, rate);
    }
    for (int i = 0; i < sim->model->n; i++) {
        sim->control.noise[i] = gb_max(sim->control.noise[i], gain * fabs(rate[i]));
    }
}

void gb_measure_noise(gb_sim *sim, double h, const gb_lanes *at, double *left, double valid) {
    const gb_model *model = sim->model;
    const double first = sim->head->counts.steps == 0 ? h : 0.0;
    double *rate = sim->k + (size_t)(GB_STAGES - 1) * (size_t)model->n_total;
    const double gain = (double)(1u << sim->head->control.doublings);
    const unsigned pattern = ++sim->head->control.noise_pattern;
    const int explicit = !(sim->method->gamma > 0.0);
    const int timed = model->n_time_terms > 0 && at->t[0] != 0.0 && sim->head->events.n_sliding == 0;
    if (timed && explicit) {
        rates_after(sim, at, rate);
        for (int i = 0; i < model->n; i++) {
            left[i] = gb_max(left[i], gain * fabs(rate[i] - sim->k1[i]));
        }
    }
    for (int i = 0; i < model->n_padded; i++) {
        const double begun = gb_max(sim->control.natural_scale[i], fabs(first * sim->k1[i]));
        const double own = 2.0 * DBL_EPSILON * gb_max(sim->control.largest[i], begun);
        const double bit = i < model->n ? gb_max(own, h * left[i]) : own;
        sim->z2[i] = sim->y0[i] + (is_raised(i, pattern) ? bit : -bit);
    }
    gb_rates(sim, 0, at, 0, sim->z2, rate);
    sim->head->counts.rhs_calls++;
    for (int i = 0; i < model->n; i++) {
        const double so_far = sim->control.noise[i], least = sim->control.largest[i] >= valid * so_far ? 0.0 : so_far;
        sim->control.noise[i] = gb_max(left[i], least);
    }
    add_noise(sim, rate, gain);
    if (timed && !explicit) {
        rates_after(sim, at, rate);
        add_noise(sim, rate, gain);
    }
}
