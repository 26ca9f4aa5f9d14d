/* Error weights and step sizes. There is no absolute tolerance: every state is measured against its own history. */
#include "gb_combine.h"

/* exp2 to about 1e-3: enough for step sizes, quick, and the same bits on every machine. */
static double rough_exp2(double x) {
    const double within = gb_min(gb_max(x, -1000.0), 1000.0), whole = floor(within), f = within - whole;
    const uint64_t bits = (uint64_t)(int64_t)(whole + 1023.0) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return power * (1.0 + f * (0.6951 + f * (0.2276 + f * 0.0773)));
}

/* How far rounding moves each rate: the response to a change of the states in their last bits, of alternating sign. */
static void measure_noise(gb_sim *sim, const double *tau) {
    const gb_model *model = sim->model;
    const int implicit = sim->method->gamma > 0.0;
    double *rate = sim->k + (size_t)(GB_STAGES - 1) * (size_t)model->n_total;
    for (int i = 0; i < model->n_padded; i++) {
        const double bit = 2.0 * DBL_EPSILON * sim->peak[i];
        sim->z2[i] = sim->y0[i] + (i % 2 == 0 ? bit : -bit);
    }
    model->rhs(sim->par, sim->mode, tau, sim->z2, rate);
    sim->head->rhs_calls++;
    for (int i = 0; i < model->n; i++) {
        rate[i] -= sim->k1[i];
    }
    if (implicit) {
        gb_stiff_response(sim, rate);
    }
    for (int i = 0; i < model->n; i++) {
        const double noise = fabs(rate[i]);
        sim->noise[i] = noise > sim->noise[i] || implicit ? noise : sim->noise[i];
    }
}

/* The largest of peak and abs(trial) in [from, to). */
static double largest_in(const double *restrict peak, const double *restrict trial, int from, int to) {
    double most[GB_PAD] = {0.0};
    int i = from;
    for (; i + GB_PAD <= to; i += GB_PAD) {
        for (int l = 0; l < GB_PAD; l++) {
            const double size = fabs(trial[i + l]), larger = size > peak[i + l] ? size : peak[i + l];
            most[l] = larger > most[l] ? larger : most[l];
        }
    }
    for (; i < to; i++) {
        most[0] = gb_max(most[0], gb_max(peak[i], fabs(trial[i])));
    }
    for (int l = 1; l < GB_PAD; l++) {
        most[0] = gb_max(most[0], most[l]);
    }
    return most[0];
}

/* What the weights of a range of states are made of. least: a part of the largest of their kind; per_time: makes a size
 * of sim->floor; first, trial: by state, sizes in their own right. */
typedef struct gb_sizes {
    double rtol, h, least, per_time;
    const double *first, *trial;
} gb_sizes;

/* The weights in [from, to); whether a state there has no size yet, for which the trial counts. */
static int weigh(const gb_sim *sim, const gb_sizes *sizes, int from, int to) {
    const double *restrict peak = sim->peak, *restrict scale = sim->scale, *restrict noise = sim->noise;
    const double *restrict floor = sim->floor, *restrict first = sizes->first, *restrict trial = sizes->trial;
    const double rtol = sizes->rtol, h = sizes->h, least = sizes->least, per_time = sizes->per_time;
    double *restrict out = sim->weight;
    int poor = 0;
    for (int i = from; i < to; i++) {
        const double known = gb_max(gb_max(peak[i], scale[i]), gb_max(least, floor[i] * per_time));
        const double own = gb_max(known, fabs(h * first[i]));
        const double size = peak[i] <= least ? gb_max(own, fabs(trial[i])) : own;
        const double weight = rtol * size + h * noise[i];
        poor |= peak[i] <= least;
        out[i] = weight > 0.0 ? 1.0 / weight : 0.0;
    }
    return poor;
}

/* 1 / (rtol size + h noise). The size of a state is its largest value so far, its natural scale where the train knows
 * one, and before the first step what its rate gives; never less than a small part of the largest of its kind (a front
 * that runs along a chain is not followed into its last digit). `trial` counts too where a state has no size at all. */
void gb_weights_refresh(gb_sim *sim, double h, const double *tau, const double *trial) {
    gb_head *head = sim->head;
    const int n = sim->model->n, speeds = n - sim->model->n_speeds;
    const int implicit = sim->method->gamma > 0.0;
    if (head->steps >= head->noise_at || (implicit && h > 4.0 * head->h_noise)) {
        measure_noise(sim, tau);
        head->h_noise = h;
        head->noise_at = 2 * head->steps + 1;
    }
    if (implicit && head->steps >= head->floor_at) {
        gb_stiff_floor(sim);
        head->floor_at = head->steps + head->steps / 4 + 1;
    }
    gb_sizes sizes = {.rtol = head->options.rtol,
                      .h = h,
                      .per_time = implicit ? 1.0 / (head->t1 - head->t_start + h) : 0.0,
                      .first = head->steps == 0 ? sim->k1 : sim->zero,
                      .trial = trial ? trial : sim->zero};
    sizes.least = 1e-10 * largest_in(sim->peak, sizes.trial, 0, speeds);
    head->poor = weigh(sim, &sizes, 0, speeds);
    sizes.least = 1e-6 * largest_in(sim->peak, sizes.trial, speeds, n);
    head->poor |= weigh(sim, &sizes, speeds, n);
    head->h_weights = h;
    head->t_weights = head->t1;
}

/* Takes the front into the sizes of the states. The weights of an implicit method are
 * kept until a size is by a tenth beyond what they were made for: the tolerance lags behind on the safe side. */
void gb_weights_grow(gb_sim *sim, const double *y) {
    const double slack = sim->method->gamma > 0.0 ? sim->head->options.rtol / 1.1 : HUGE_VAL;
    double grown = 0.0;
    for (int b = 0; b < sim->model->n_padded; b += GB_PAD) {
        for (int l = b; l < b + GB_PAD; l++) {
            const double size = fabs(y[l]), peak = sim->peak[l];
            grown = size > peak && !(size * slack * sim->weight[l] <= 1.0) ? 1.0 : grown;
            sim->peak[l] = size > peak ? size : peak;
        }
    }
    if (grown != 0.0) {
        sim->head->h_weights = 0.0;
    }
}

/* The state whose error decided. */
int gb_worst_state(const gb_sim *sim) {
    int worst = 0;
    double largest = -1.0;
    for (int b = 0; b < sim->model->n_padded; b += GB_PAD) {
        double error[GB_PAD];
        gb_combine(&sim->method->e[0], sim->k + b, sim->model->n_total, 0, GB_PAD, sim->zero, 1.0, error);
        for (int l = 0; l < GB_PAD && b + l < sim->model->n; l++) {
            const double ratio = fabs(error[l]) * sim->weight[b + l];
            if (ratio > largest) {
                largest = ratio;
                worst = b + l;
            }
        }
    }
    return worst;
}

/* Factor of the next step size after a step with this error (PI control: Hairer, Wanner 1996, IV.2). */
double gb_step_factor(gb_sim *sim, double log_error, int accepted) {
    gb_head *head = sim->head;
    const double order = (double)sim->method->error_order, beta = sim->method->beta;
    if (!accepted) {
        return gb_min(gb_max(0.85 * rough_exp2(-log_error / order), 0.2), 0.95);
    }
    const double factor = 0.85 * rough_exp2((0.75 * beta - 1.0 / order) * log_error + beta * head->log_error);
    head->log_error = gb_max(log_error, -13.0);
    return gb_min(gb_max(factor, 0.3), head->steps == 0 ? 100.0 : 6.0);
}

/* Largest size-relative rate of x: max |x_i| / (size_i), over the states that have a size. */
static double relative(const gb_sim *sim, const double *x, const double *minus) {
    double most = 0.0;
    for (int i = 0; i < sim->model->n; i++) {
        const double size = gb_max(sim->peak[i], sim->scale[i]);
        if (size > 0.0) {
            most = gb_max(most, fabs(x[i] - (minus ? minus[i] : 0.0)) / size);
        }
    }
    return most;
}

/* A first step from the rates at the start and after a small Euler step (after Hairer, Norsett, Wanner 1993, II.4). */
double gb_first_step(gb_sim *sim) {
    const gb_model *model = sim->model;
    const gb_head *head = sim->head;
    const double first = relative(sim, sim->k, NULL);
    const double h = first > 0.0 ? gb_min(1e-3 / first, 1e-3) : 1e-6;
    double *rate = sim->k + (size_t)model->n_total;
    for (int i = 0; i < model->n_padded; i++) {
        sim->z2[i] = sim->y0[i] + h * sim->k[i];
    }
    model->rhs(sim->par, sim->mode, sim->tau_one, sim->z2, rate);
    sim->head->rhs_calls++;
    const double second = sqrt(relative(sim, rate, sim->k) / h);
    const double pace = gb_max(first, second);
    const double small = pow(0.01 * head->options.rtol, 1.0 / sim->method->error_order);
    return pace > 0.0 && pace < HUGE_VAL ? gb_min(small / pace, 1e3 * h) : h;
}
