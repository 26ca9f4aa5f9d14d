#include "gb_noise.h"
#include "gb_active_set.h"
#include "gb_constraint_forces.h"
#include "gb_constraint_state.h"
#include "gb_rates.h"
#include "gb_rosenbrock.h"
#include "gb_vector.h"

/* Rounding of the acceleration of what locks hold, in parts of those that make it up. */
static const double OF_LOCKS = 256.0 * DBL_EPSILON;

/* Part of it by which noise is more. */
static const double MORE = 1.0 + 1e-6;

/* By how much the rates of implicit methods in time, which are differences over a small part of a step, are noisier. */
static const double OF_DIFFERENCES = 1e2;

/* What noise is multiplied by because trials were refused for it. */
static double gain_of_doublings(const gb_sim *sim) {
    return (double)(1u << sim->head->control.doublings);
}

/* What rounds in the force of each active constraint: itself, and what others do to its slip, which it answers. */
static void sizes_of_forces(gb_sim *sim, const double *time_terms, const double *y, double *size) {
    const gb_delassus W = gb_delassus_of(sim);
    double *force = sim->constraints.other;
    sim->model->constraint_forces(sim->par, sim->mode, time_terms, y, force, size);
    sim->model->delassus(sim->par, sim->mode, time_terms, y, 0, sim->constraints.delassus);
    for (int j = 0; j < W.n; j++) {
        force[j] = gb_is_active(sim, j) ? force[j] : 0.0;
    }
    for (int j = 0; j < W.n; j++) {
        double terms = 0.0;
        gb_delassus_product(&W, j, force, &terms);
        const double own = gb_is_active(sim, j) ? gb_delassus_diagonal(&W, j) : 0.0;
        size[j] = own > 0.0 ? gb_max(fabs(force[j]), terms / own) : 0.0;
    }
}

/* Accelerations that forces of these sizes make, which cancel in those that have been found: the largest with signs by
 * each bit of their number, by which any two of them differ once. */
static void accelerations_of_locks(gb_sim *sim, const double *time_terms, const double *y, double *most) {
    const gb_model *model = sim->model;
    const int first = model->n - model->n_speeds;
    double *size = sim->constraints.right, *impulse = sim->constraints.other, *moved = sim->z2;
    sizes_of_forces(sim, time_terms, y, size);
    memset(most, 0, sizeof(double) * (size_t)model->n);
    for (unsigned bit = 1; bit <= 2 * (unsigned)model->n_constraints; bit *= 2) {
        for (int j = 0; j < model->n_constraints; j++) {
            impulse[j] = (unsigned)j & bit ? -size[j] : size[j];
        }
        memcpy(moved, y, sizeof(double) * (size_t)model->n_total);
        memset(moved + first, 0, sizeof(double) * (size_t)model->n_speeds);
        model->apply_impulses(sim->par, sim->mode, time_terms, impulse, moved);
        for (int i = first; i < model->n; i++) {
            most[i] = gb_max(most[i], fabs(moved[i]));
        }
    }
}

/* What locks make one moves as one: of two speeds that such a row ties, each has the noise of the other, times the
 * gain, where that is more. A body that hangs at a lock that carries nothing follows what others make of the one it
 * hangs at. */
static void share_among_tied(const gb_sim *sim, double *noise) {
    const gb_constraint_rows *rows = sim->model->constraint_rows;
    const gb_active_set a = gb_active_at(rows, sim->mode + sim->model->n_switches);
    double *of = noise + (sim->model->n - sim->model->n_speeds);
    int changed = 1;
    for (int round = 0; changed && round <= *a.n_rows; round++) {
        changed = 0;
        for (int r = 0; r < *a.n_rows; r++) {
            const int e = a.start[r], two = a.start[r + 1] == e + 1 && a.value[e] != 0.0;
            double *one = of + rows->speed[a.pivot[r]], *other = two ? of + rows->speed[a.column[e]] : one;
            const double gain = two ? fabs(a.value[e]) : 1.0;
            if (MORE * *one < gain * *other) {
                *one = gain * *other;
                changed = 1;
            } else if (MORE * gain * *other < *one) {
                *other = *one / gain;
                changed = 1;
            }
        }
    }
}

int gb_noise_of_locks(gb_sim *sim, const double *time_terms, const double *y, double *left) {
    const gb_model *model = sim->model;
    const int differenced = sim->method->gamma > 0.0 && model->n_time_terms > 0;
    const double part = OF_LOCKS * (differenced ? OF_DIFFERENCES : 1.0) * gain_of_doublings(sim);
    double *most = sim->k + (size_t)GB_SLOPE * (size_t)model->n_total;
    int beyond = 0;
    gb_free_rates(sim, time_terms, y, left);
    accelerations_of_locks(sim, time_terms, y, most);
    for (int i = 0; i < model->n; i++) {
        const double noise = i < model->n - model->n_speeds ? 0.0 : part * (fabs(left[i]) + most[i]);
        left[i] = noise < HUGE_VAL ? noise : 0.0;
    }
    memcpy(most, left, sizeof(double) * (size_t)model->n);
    share_among_tied(sim, left);
    const double elapsed = sim->head->front.t1 - sim->head->front.t_start + sim->head->front.h;
    const int begins = sim->head->control.unscaled || sim->head->counts.steps == 0;
    for (int i = 0; i < model->n; i++) { /* what has moved by more than that has a scale of its own */
        const int shares = (begins && most[i] == 0.0) || sim->control.largest[i] <= left[i] * elapsed;
        left[i] = shares ? left[i] : most[i];
    }
    for (int i = 0; i < model->n; i++) {
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

/* Rates at y0, time moved by this: by its last bits what its rounding makes of them. Inputs stay. */
static void rates_after(gb_sim *sim, const gb_lanes *at, double moved, double *rate) {
    gb_lanes *own = &sim->sliding.lanes;
    for (int l = 0; l < GB_LANES; l++) {
        own->t[l] = at->t[0] + moved;
        for (int i = 0; i < sim->model->n_inputs; i++) {
            own->u[i * GB_LANES + l] = at->u[i * GB_LANES];
        }
    }
    sim->model->time_terms(sim->par, sim->mode, 1, own->t, own->u, own->time_terms);
    gb_rates(sim, 0, own, 0, sim->y0, rate);
    sim->head->counts.rhs_calls++;
}

/* Adds to the noise by how far these rates are from those that are known, times the gain of each. */
static void add_noise(gb_sim *sim, double *rate, const double *gain) {
    for (int i = 0; i < sim->model->n; i++) {
        rate[i] -= sim->k1[i];
    }
    if (sim->method->gamma > 0.0) {
        gb_rosenbrock_response(sim, rate);
    }
    for (int i = 0; i < sim->model->n; i++) {
        sim->control.noise[i] = gb_max(sim->control.noise[i], gain[i] * fabs(rate[i]));
    }
}

/* Gains of noise: the slope in time of implicit methods is a difference between two instants, in which rounding is
 * larger; what time has no part in rounds alike at both. */
static void find_gains(gb_sim *sim, double h, const gb_lanes *at, int differenced, double *rate, double *gain) {
    const double all = gain_of_doublings(sim), apart = gb_rosenbrock_time_step(at->t[0], h);
    if (differenced) {
        rates_after(sim, at, apart, rate);
    }
    for (int i = 0; i < sim->model->n; i++) {
        gain[i] = differenced && rate[i] != sim->k1[i] ? gb_max(2.0 * h / apart, 1.0) * all : all;
    }
}

/* Adds what the rates do when each state is moved by its bits, which lie in z2. */
static void add_noise_of_bits(gb_sim *sim, const gb_lanes *at, double *rate, const double *gain) {
    double *bits = sim->z2;
    for (int i = 0; i < sim->model->n_padded; i++) {
        bits[i] = sim->y0[i] + (is_raised(i, sim->head->control.noise_pattern) ? bits[i] : -bits[i]);
    }
    gb_rates(sim, 0, at, 0, bits, rate);
    sim->head->counts.rhs_calls++;
    add_noise(sim, rate, gain);
}

/* Adds what the rates do when each speed is moved by what an acceleration that is rounding makes in h. What it gained
 * in the slope in time it has gained. */
static void add_noise_of_left(gb_sim *sim, double h, const gb_lanes *at, const double *left, double *rate,
                              double *gain) {
    int any = 0;
    memset(sim->z2, 0, sizeof(double) * (size_t)sim->model->n_padded);
    for (int i = 0; i < sim->model->n; i++) {
        sim->z2[i] = h * left[i];
        gain[i] = gain_of_doublings(sim);
        any |= left[i] > 0.0;
    }
    if (any) {
        add_noise_of_bits(sim, at, rate, gain);
    }
}

void gb_measure_noise(gb_sim *sim, double h, const gb_lanes *at, double *left, double valid) {
    const gb_model *model = sim->model;
    const double first = sim->head->counts.steps == 0 ? h : 0.0, last_bits = 2.0 * DBL_EPSILON * fabs(at->t[0]);
    double *rate = sim->k + (size_t)(GB_STAGES - 1) * (size_t)model->n_total;
    double *gain = sim->k + (size_t)GB_SLOPE * (size_t)model->n_total;
    const int timed = model->n_time_terms > 0 && at->t[0] != 0.0 && sim->head->events.n_sliding == 0;
    const int differenced = timed && sim->method->gamma > 0.0;
    sim->head->control.noise_pattern++;
    find_gains(sim, h, at, differenced, rate, gain);
    if (timed && !differenced) {
        rates_after(sim, at, last_bits, rate);
        for (int i = 0; i < model->n; i++) {
            left[i] = gb_max(left[i], gain[i] * fabs(rate[i] - sim->k1[i]));
        }
    }
    for (int i = 0; i < model->n; i++) {
        const double so_far = sim->control.noise[i], least = sim->control.largest[i] >= valid * so_far ? 0.0 : so_far;
        sim->control.noise[i] = gb_max(left[i], least);
    }
    for (int i = 0; i < model->n_padded; i++) {
        const double begun = gb_max(sim->control.natural_scale[i], fabs(first * sim->k1[i]));
        const double own = 2.0 * DBL_EPSILON * gb_max(sim->control.largest[i], begun);
        sim->z2[i] = i < model->n && !differenced ? gb_max(own, h * left[i]) : own;
    }
    add_noise_of_bits(sim, at, rate, gain);
    if (differenced) {
        rates_after(sim, at, last_bits, rate);
        add_noise(sim, rate, gain);
        add_noise_of_left(sim, h, at, left, rate, gain);
    }
}
