#include "gb_error_control.h"
#include "gb_constraint_state.h"
#include "gb_noise.h"
#include "gb_rates.h"
#include "gb_rosenbrock.h"
#include "gb_vector.h"

double gb_rough_exp2(double x) {
    const double within = gb_min(gb_max(x, -1000.0), 1000.0), whole = floor(within), f = within - whole;
    const uint64_t bits = (uint64_t)(int64_t)(whole + 1023.0) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return power * (1.0 + f * (0.6951 + f * (0.2276 + f * 0.0773)));
}

double gb_rough_log2(double x) {
    uint64_t bits;
    double m;
    memcpy(&bits, &x, sizeof bits);
    const double exponent = (double)(int)(bits >> 52) - 1023.0;
    bits = (bits & 0xfffffffffffffu) | 0x3ff0000000000000u;
    memcpy(&m, &bits, sizeof m);
    const double f = m - 1.0;
    return exponent + f * (1.4234 + f * (-0.5877 + f * 0.1643));
}

/* How often noise may be doubled that a trial was refused for: stages and laws round several times. */
static const unsigned MOST_DOUBLINGS = 8;

/* The largest of peak and abs(trial) in [from, to). */
static double largest_in(const double *restrict peak, const double *restrict trial, int from, int to) {
    gb_half most = {0.0};
    double rest = 0.0;
    int i = from;
    for (; i + GB_PAD / 2 <= to; i += GB_PAD / 2) {
        gb_half size = *gb_half_at(trial + i);
        gb_half_abs(&size);
        gb_half_max(&size, gb_half_at(peak + i));
        gb_half_max(&most, &size);
    }
    for (; i < to; i++) {
        rest = gb_max(rest, gb_max(peak[i], fabs(trial[i])));
    }
    return gb_max(rest, gb_half_largest(&most));
}

/* What the error weights of a range of states are made of. least: a part of the largest of their kind; per_time: makes
 * a scale of least_scale; begun: of what has not moved before; trusted: natural scales from which on the trial does not
 * count (a step from rest may end far beyond an event); first, trial: by state, scales in their own right. */
typedef struct gb_sizes {
    double rtol, h, least, per_time, begun, trusted;
    const double *first, *trial;
} gb_sizes;

/* Less noise than the rest of it leaves no trace in the steps, which are the same in any order of the parts. */
static const double UNSEEN = 1.0 - 1e-6;

/* What is smaller has no digits for a relative tolerance where it comes out of underflow: the least error that counts.
 * It is far below GB_UNDERFLOW: sides of losses are told from what is followed with all its digits alone. */
static const double LEAST = 1e-290;

/* The error weights in [from, to); whether a state there has no scale yet, for which the trial counts, or has never
 * moved, in the trial neither. */
static int weigh(const gb_sim *sim, const gb_sizes *sizes, int from, int to) {
    const double *restrict peak = sim->control.largest, *restrict scale = sim->control.natural_scale,
                           *restrict noise = sim->control.noise;
    const double *restrict floor = sim->control.least_scale, *restrict first = sizes->first,
                           *restrict trial = sizes->trial;
    const double rtol = sizes->rtol, h = sizes->h, least = sizes->least, per_time = sizes->per_time,
                 trusted = sizes->trusted;
    double *restrict out = sim->control.error_weight;
    int poor = 0;
    for (int i = from; i < to; i++) {
        const double begun = peak[i] == 0.0 ? sizes->begun : peak[i];
        const double known = gb_max(gb_max(begun, scale[i]), gb_max(least, floor[i] * per_time));
        const double own = gb_max(known, fabs(h * first[i]));
        const double size = peak[i] <= least && scale[i] < trusted ? gb_max(own, fabs(trial[i])) : own;
        const double own_part = rtol * size, weight = gb_max(own_part, UNSEEN * own_part + h * noise[i]);
        poor |= peak[i] > least ? 0 : peak[i] == 0.0 && trial[i] == 0.0 ? GB_AT_REST : GB_SMALL;
        out[i] = weight > 0.0 ? 1.0 / gb_max(weight, LEAST) : 0.0;
    }
    return poor;
}

int gb_begins_to_move(const gb_sim *sim) {
    const gb_half none = {0.0};
    gb_bits moves = {0};
    if (sim->head->control.unscaled & GB_SMALL) {
        return 1;
    }
    for (int i = 0; i < sim->model->n_padded; i += GB_PAD / 2) {
        moves |= (*gb_half_at(sim->control.largest + i) == none) & (*gb_half_at(sim->z + i) != none);
    }
    return (moves[0] | moves[1] | moves[2] | moves[3]) != 0;
}

/* Speeds of a trial in parts of the largest so far beyond which it has run away: what rounds there says nothing. */
static const double RUN_AWAY = 1e6;

/* What rounding leaves of the forces of locks where nothing loads them at the front: at the end of the trial by which
 * the train begins to move, for the speeds that have not moved by more. Whether there is any. */
static int noise_of_first_load(gb_sim *sim, double h, const double *time_terms, const double *trial, double *left) {
    const int n = sim->model->n, speeds = n - sim->model->n_speeds;
    const double fastest = largest_in(sim->control.largest, sim->zero, speeds, n);
    int any = 0;
    if (fastest > 0.0 && largest_in(sim->zero, trial, speeds, n) > RUN_AWAY * fastest) {
        return 0;
    }
    gb_noise_of_locks(sim, time_terms, trial, left);
    for (int i = 0; i < sim->model->n; i++) {
        left[i] = fabs(trial[i]) <= h * left[i] ? left[i] : 0.0;
        any |= left[i] > 0.0;
    }
    return any;
}

/* Noise is most of the tolerance of a state that has a scale. */
static int is_noisy(const gb_sim *sim, double h) {
    int noisy = 0;
    for (int i = 0; i < sim->model->n; i++) {
        noisy |= gb_has_scale(sim, i) && h * sim->control.noise[i] * sim->control.error_weight[i] > 0.5;
    }
    return noisy;
}

static void renew_least_scales(gb_sim *sim) {
    gb_head *head = sim->head;
    if (head->counts.steps >= head->control.least_scale_at) {
        gb_least_scales(sim);
        head->control.least_scale_at = head->counts.steps + head->counts.steps / 4 + 1;
    }
}

void gb_error_weights(gb_sim *sim, double h, const gb_lanes *at, const double *trial) {
    gb_head *head = sim->head;
    const int n = sim->model->n, speeds = n - sim->model->n_speeds, implicit = sim->method->gamma > 0.0;
    /* what begins to move has its rounding for a scale, and it had none in other modes */
    const int moved = trial != NULL && head->control.noise_modes != head->events.mode_hash;
    const int longer = h > 4.0 * head->control.h_noise && (implicit || head->control.unscaled);
    double *left = sim->k + (size_t)(implicit ? GB_SPARE - 1 : GB_STAGES - 3) * (size_t)sim->model->n_total;
    const int shorter = implicit && gb_noise_is_of_longer(sim, h);
    const int due = head->counts.steps >= head->control.noise_at || (implicit && moved) || longer || shorter;
    const int follows = trial != NULL && (head->counts.steps == 0 || gb_begins_to_move(sim));
    const int locked = (follows || due) && gb_some_active(sim);
    const double *time_terms = at->time_terms + sim->method->stages;
    const int noisier = locked && gb_noise_of_locks(sim, time_terms, sim->y0, left);
    const int unloaded = locked && follows && largest_in(left, sim->zero, 0, n) == 0.0;
    const int loads = unloaded && noise_of_first_load(sim, h, time_terms, trial, left);
    if (due || noisier || loads) {
        const double elapsed = head->front.t1 - head->front.t_start + h;
        if (!locked) {
            memset(left, 0, sizeof(double) * (size_t)n);
        }
        const double old = moved || shorter ? 0.0 : longer ? elapsed : HUGE_VAL;
        const double valid = implicit ? old : HUGE_VAL;
        gb_measure_noise(sim, h, at, left, loads ? 0.0 : valid);
        head->control.noise_modes = head->events.mode_hash;
        head->control.h_noise = h;
        head->control.noise_at = 2 * head->counts.steps + 1;
    }
    if (implicit) {
        renew_least_scales(sim);
    }
    gb_sizes sizes = {.rtol = head->options.rtol,
                      .h = h,
                      .per_time = implicit ? 1.0 / (head->front.t1 - head->front.t_start + h) : 0.0,
                      .first = head->counts.steps == 0 ? sim->k1 : sim->zero,
                      .trial = trial ? trial : sim->zero};
    if (head->control.natural < 0.0) {
        head->control.natural_coordinate = largest_in(sim->control.natural_scale, sim->zero, 0, speeds);
        head->control.natural = largest_in(sim->control.natural_scale, sim->zero, speeds, n);
    }
    const double least_speed =
        1e-6 * gb_max(largest_in(sim->control.largest, sizes.trial, speeds, n), head->control.natural);
    sizes.trusted = HUGE_VAL;
    /* a load like t^4 is as wrong in a step from rest, relative to what it moves, however short that is */
    sizes.begun = h * least_speed;
    sizes.least =
        1e-10 * gb_max(largest_in(sim->control.largest, sizes.trial, 0, speeds), head->control.natural_coordinate);
    head->control.least_coordinate = sizes.least;
    head->control.least_speed = least_speed;
    head->control.unscaled = weigh(sim, &sizes, 0, speeds);
    sizes.begun = 0.0;
    sizes.least = least_speed;
    sizes.trusted = DBL_MIN;
    head->control.unscaled |= weigh(sim, &sizes, speeds, n);
    head->control.h_weights = h;
    head->control.t_weights = head->front.t1;
    head->control.noisy = implicit && is_noisy(sim, h);
}

void gb_forget_trial(gb_sim *sim, double error) {
    struct gb_pace *control = &sim->head->control;
    if (control->refused_at == sim->head->counts.steps + 1 && error > control->log_refused - 1.0) {
        const int worst = gb_worst_state(sim);
        const double share = control->h_weights * sim->control.noise[worst] * sim->control.error_weight[worst];
        control->doublings += share > 0.5 && control->doublings < MOST_DOUBLINGS;
        control->noise_at = sim->head->counts.steps;
        control->h_weights = 0.0;
    }
    control->refused_at = sim->head->counts.steps + 1;
    control->log_refused = error;
}

void gb_scales_grow(gb_sim *sim, const double *y) {
    const double slack = sim->method->gamma > 0.0 ? sim->head->options.rtol / 1.1 : HUGE_VAL;
    gb_bits grown = {0};
    for (int i = 0; i < sim->model->n_padded; i += GB_PAD / 2) {
        gb_half size = *gb_half_at(y + i), *peak = (gb_half *)(void *)(sim->control.largest + i);
        gb_half_abs(&size);
        grown |= (size > *peak) & ~(size * slack * *gb_half_at(sim->control.error_weight + i) <= 1.0);
        gb_half_max(peak, &size);
    }
    if ((grown[0] | grown[1] | grown[2] | grown[3]) != 0) {
        sim->head->control.h_weights = 0.0;
    }
}

int gb_worst_state(const gb_sim *sim) {
    int worst = 0;
    double largest = -1.0;
    for (int b = 0; b < sim->model->n_padded; b += GB_PAD) {
        double error[GB_PAD];
        gb_combine(&sim->method->e[0], sim->k + b, sim->model->n_total, 0, GB_PAD, sim->zero, 1.0, error);
        for (int l = 0; l < GB_PAD && b + l < sim->model->n; l++) {
            const double ratio = fabs(error[l]) * sim->control.error_weight[b + l];
            if (ratio > largest) {
                largest = ratio;
                worst = b + l;
            }
        }
    }
    return worst;
}

double gb_step_factor(gb_sim *sim, double log_error, int accepted) {
    gb_head *head = sim->head;
    const double order = (double)sim->method->error_order, beta = sim->method->beta;
    if (!accepted) {
        return gb_min(gb_max(0.85 * gb_rough_exp2(-log_error / order), 0.2), 0.95);
    }
    const double factor =
        0.85 * gb_rough_exp2((0.75 * beta - 1.0 / order) * log_error + beta * head->control.log_error);
    head->control.log_error = gb_max(log_error, -13.0);
    return gb_min(gb_max(factor, 0.3), head->counts.steps == 0 ? 100.0 : 6.0);
}

/* Largest size-relative rate of x: max |x_i| / (size_i), over the states that have a size. */
static double relative(const gb_sim *sim, const double *x, const double *minus) {
    double most = 0.0;
    for (int i = 0; i < sim->model->n; i++) {
        const double size = gb_max(sim->control.largest[i], sim->control.natural_scale[i]);
        if (size > 0.0) {
            most = gb_max(most, fabs(x[i] - (minus ? minus[i] : 0.0)) / size);
        }
    }
    return most;
}

/* A first step is no shorter than this many roundings of time: an angle that a run begins with may be rounding beside
 * its turn, and so is what its rate says of the length then. */
static const double TOLD_FROM_TIME = 64.0;

double gb_first_step(gb_sim *sim) {
    const gb_model *model = sim->model;
    const gb_head *head = sim->head;
    const double first = relative(sim, sim->k, NULL);
    const double h = first > 0.0 ? gb_min(1e-3 / first, 1e-3) : 1e-6;
    double *rate = sim->k + (size_t)model->n_total;
    for (int i = 0; i < model->n_padded; i++) {
        sim->z2[i] = sim->y0[i] + h * sim->k[i];
    }
    gb_rates(sim, 0, &sim->instant, 0, sim->z2, rate);
    sim->head->counts.rhs_calls++;
    const double second = sqrt(relative(sim, rate, sim->k) / h);
    const double pace = gb_max(first, second);
    const double small = pow(0.01 * head->options.rtol, 1.0 / sim->method->error_order);
    const double size = pace > 0.0 && pace < HUGE_VAL ? gb_min(small / pace, 1e3 * h) : h;
    return gb_max(size, TOLD_FROM_TIME * DBL_EPSILON * fabs(head->front.t1));
}

/* max |sum_j e_j k_j| weight over the states, without the factor h. */
static double error_norm(const gb_sim *sim, const gb_weights *e) {
    gb_half worst = {0.0};
    for (int b = 0; b < sim->model->n_padded; b += GB_PAD) {
        double error[GB_PAD];
        gb_combine(e, sim->k + b, sim->model->n_total, 0, GB_PAD, sim->zero, 1.0, error);
        for (int l = 0; l < GB_PAD; l += GB_PAD / 2) {
            gb_half size = *gb_half_at(error + l);
            gb_half_abs(&size);
            size *= *gb_half_at(sim->control.error_weight + b + l);
            gb_half_max(&worst, &size);
        }
    }
    return gb_half_largest(&worst);
}

/* The same where the estimate is the last stage. */
static double last_norm(const gb_sim *sim) {
    const double *k = sim->k + (size_t)(sim->method->stages - 1) * (size_t)sim->model->n_total;
    gb_half worst = {0.0};
    for (int i = 0; i < sim->model->n_padded; i += GB_PAD / 2) {
        gb_half size = *gb_half_at(k + i);
        gb_half_abs(&size);
        size *= *gb_half_at(sim->control.error_weight + i);
        gb_half_max(&worst, &size);
    }
    return gb_half_largest(&worst);
}

double gb_log_error(const gb_sim *sim, double h) {
    const gb_method *method = sim->method;
    const double first = h * (method->gamma > 0.0 ? last_norm(sim) : error_norm(sim, &method->e[0]));
    if (!(first > 1e-30)) {
        return -100.0;
    }
    if (method->n_errors == 1) {
        return gb_rough_log2(first);
    }
    const double second = h * error_norm(sim, &method->e[1]);
    if (sim->unlocated.crossed) { /* at a corner both are of order 2, and their quotient tells nothing */
        return gb_rough_log2(gb_max(first, 0.1 * second));
    }
    return 2.0 * gb_rough_log2(first) - 0.5 * gb_rough_log2(first * first + 0.01 * second * second);
}
