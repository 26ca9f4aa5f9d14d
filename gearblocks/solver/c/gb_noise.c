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

/* Sum of the weights by which time terms in a step make its tangent (Rosenbrock.slope_weights). */
static const double OF_TANGENTS = 128.0;

/* What noise is multiplied by because trials were refused for it. */
static double gain_of_doublings(const gb_sim *sim) {
    return (double)(1u << sim->head->control.doublings);
}

/* The same for a difference between two instants, which the slope in time of implicit methods is: over a step. */
static double gain_of_slope(const gb_sim *sim, double h, double apart) {
    return gb_max(2.0 * h / apart, 1.0) * gain_of_doublings(sim);
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

/* What locks make one moves as one: of two speeds that such a row ties, the one that follows has the noise of the
 * other, times the gain, where that is more. A body that hangs at a lock that carries nothing follows what others make
 * of the one it hangs at. */
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

/* Lanes of their own with time moved by this. Inputs stay. */
static gb_lanes *lanes_after(gb_sim *sim, const gb_lanes *at, double moved) {
    gb_lanes *own = &sim->sliding.lanes;
    for (int l = 0; l < GB_LANES; l++) {
        own->t[l] = at->t[0] + moved;
        for (int i = 0; i < sim->model->n_inputs; i++) {
            own->u[i * GB_LANES + l] = at->u[i * GB_LANES];
        }
    }
    return own;
}

/* Rates at y0 at that time: moved by its last bits what its rounding makes of them. */
static void rates_after(gb_sim *sim, const gb_lanes *at, double moved, double *rate) {
    gb_lanes *own = lanes_after(sim, at, moved);
    sim->model->time_terms(sim->par, sim->mode, 1, own->t, own->u, own->time_terms);
    gb_rates(sim, 0, own, 0, sim->y0, rate);
    sim->head->counts.rhs_calls++;
}

enum { WITHOUT_SCALE, WITH_SCALE, ALL };

/* Adds to the noise of these states what these changes of the rates make of a step, times a gain; times another one for
 * those without a scale that the second instant of a difference in time changes (NULL: none). */
static void add_noise(gb_sim *sim, int which, double *change, double gain, const double *second, double of_slope) {
    if (sim->method->gamma > 0.0) {
        gb_rosenbrock_response(sim, change);
    }
    for (int i = 0; i < sim->model->n; i++) {
        const int scaled = gb_has_scale(sim, i), slopes = second && (which == ALL ? !scaled : 1);
        const double own = slopes && second[i] != sim->k1[i] ? of_slope : gain;
        if (which == ALL || which == scaled) {
            sim->control.noise[i] = gb_max(sim->control.noise[i], own * fabs(change[i]));
        }
    }
}

/* Rates at z2, or at y0 after this time, less those that are known. */
static void change_of_rates(gb_sim *sim, const gb_lanes *at, double moved, double *rate) {
    if (moved > 0.0) {
        rates_after(sim, at, moved, rate);
    } else {
        gb_rates(sim, 0, at, 0, sim->z2, rate);
        sim->head->counts.rhs_calls++;
    }
    for (int i = 0; i < sim->model->n; i++) {
        rate[i] -= sim->k1[i];
    }
}

/* Noise of the slope in time of implicit methods, a difference between two instants: the second one moved a little, its
 * rates are off the line through both by their rounding. What the states alone make of the rates rounds alike at all
 * instants. Without a scale, where that may be nothing by chance: all that time changes. */
static void add_noise_of_slope(gb_sim *sim, double h, const gb_lanes *at, double *rate, const double *second) {
    const double gain = gain_of_doublings(sim), apart = gb_rosenbrock_time_step(at->t[0], h);
    const double moved = gb_max(1e-9 * apart, 8.0 * DBL_EPSILON * fabs(at->t[0]));
    if (sim->head->counts.steps > 0) {
        change_of_rates(sim, at, apart + moved, rate);
        for (int i = 0; i < sim->model->n; i++) {
            const double line = second[i] - sim->k1[i];
            rate[i] = rate[i] - line - moved / apart * line;
        }
        add_noise(sim, WITH_SCALE, rate, gain, second, gain_of_slope(sim, h, apart));
    }
    if (sim->head->control.unscaled || sim->head->counts.steps == 0) {
        change_of_rates(sim, at, 2.0 * DBL_EPSILON * fabs(at->t[0]), rate);
        add_noise(sim, WITHOUT_SCALE, rate, gain, second, gain_of_slope(sim, h, apart));
    }
}

/* What rounding of the time terms themselves, where they are sums, makes of the rates. */
static void change_by_terms(gb_sim *sim, const gb_lanes *at, double *rate) {
    const gb_model *model = sim->model;
    gb_lanes *own = lanes_after(sim, at, 0.0);
    for (int i = 0; i < model->n_time_terms; i++) {
        own->time_terms[(size_t)i * GB_LANES] = 0.0;
    }
    model->time_term_sizes(sim->par, sim->mode, 1, own->t, own->u, own->time_terms);
    for (int i = 0; i < model->n_time_terms; i++) {
        const double bits = 2.0 * DBL_EPSILON * own->time_terms[(size_t)i * GB_LANES];
        const int raised = is_raised(i, sim->head->control.noise_pattern);
        own->time_terms[(size_t)i * GB_LANES] = at->time_terms[(size_t)i * GB_LANES] + (raised ? bits : -bits);
    }
    gb_rates(sim, 0, own, 0, sim->y0, rate);
    sim->head->counts.rhs_calls++;
    for (int i = 0; i < model->n; i++) {
        rate[i] -= sim->k1[i];
    }
}

void gb_measure_noise(gb_sim *sim, double h, const gb_lanes *at, double *left, double valid) {
    const gb_model *model = sim->model;
    const double first = sim->head->counts.steps == 0 ? h : 0.0, last_bits = 2.0 * DBL_EPSILON * fabs(at->t[0]);
    double *rate = sim->k + (size_t)(GB_STAGES - 1) * (size_t)model->n_total;
    double *second = sim->k + (size_t)GB_SLOPE * (size_t)model->n_total;
    const unsigned pattern = ++sim->head->control.noise_pattern;
    const int timed = model->n_time_terms > 0 && at->t[0] != 0.0 && sim->head->events.n_sliding == 0;
    const int implicit = sim->method->gamma > 0.0;
    const int summed = model->time_term_sizes != NULL && sim->head->events.n_sliding == 0;
    const double gain = gain_of_doublings(sim), apart = gb_rosenbrock_time_step(at->t[0], h);
    if (timed && implicit) {
        rates_after(sim, at, apart, second);
    } else if (timed) {
        change_of_rates(sim, at, last_bits, rate);
        for (int i = 0; i < model->n; i++) {
            left[i] = gb_max(left[i], gain * fabs(rate[i]));
        }
    }
    if (summed && !implicit) {
        change_by_terms(sim, at, rate);
        for (int i = 0; i < model->n; i++) {
            left[i] = gb_max(left[i], gain * fabs(rate[i]));
        }
    }
    for (int i = 0; i < model->n; i++) {
        rate[i] = is_raised(i, pattern) ? left[i] : -left[i];
    }
    if (implicit && sim->head->counts.steps > 0) { /* what is stiff, or held by others, does not follow its noise */
        gb_rosenbrock_response(sim, rate);
    }
    for (int i = 0; i < model->n_padded; i++) {
        const double begun = gb_max(sim->control.natural_scale[i], fabs(first * sim->k1[i]));
        const double own = 2.0 * DBL_EPSILON * gb_max(sim->control.largest[i], begun);
        const double reached = i < model->n ? h * (implicit && gb_has_scale(sim, i) ? fabs(rate[i]) : left[i]) : 0.0;
        const double bit = gb_max(own, reached);
        sim->z2[i] = sim->y0[i] + (is_raised(i, pattern) ? bit : -bit);
    }
    for (int i = 0; i < model->n; i++) {
        const double so_far = sim->control.noise[i], least = sim->control.largest[i] >= valid * so_far ? 0.0 : so_far;
        sim->control.noise[i] = gb_max(left[i], least);
    }
    change_of_rates(sim, at, 0.0, rate);
    add_noise(sim, ALL, rate, gain, timed && implicit ? second : NULL, gain_of_slope(sim, h, apart));
    if (timed && implicit) {
        add_noise_of_slope(sim, h, at, rate, second);
    }
    if (summed && implicit) {
        change_by_terms(sim, at, rate);
        add_noise(sim, ALL, rate, OF_TANGENTS * gain, NULL, 0.0);
    }
}
