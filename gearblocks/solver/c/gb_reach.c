#include "gb_reach.h"
#include "gb_error_control.h"
#include "gb_rates.h"
#include "gb_vector.h"

/* Most steps from one look to the next, fewest where modes change all the time, and those that modes have had which are
 * new. */
enum { SELDOM = 64, OFTEN = 12, BEGUN = 4 };

/* By how much a step may reach further than what a look along the iteration says, and the length of u in scales of the
 * states: differences of rates stand clear of rounding there, and the laws are straight. */
static const double SLACK = 1.1, LENGTH = 1e-6;

/* Part of the direction of a look that is of this step alone. */
static const double MIXED = 0.03;

/* sum a b weight^2, of the states. */
static double product(const gb_sim *sim, const double *a, const double *b) {
    gb_block sum = {0.0};
    for (int i = 0; i < sim->model->n_padded; i += GB_PAD) {
        const gb_block weight = *gb_block_at(sim->control.error_weight + i);
        sum += (weight * *gb_block_at(a + i)) * (weight * *gb_block_at(b + i));
    }
    return gb_block_sum(&sum);
}

/* out = J u: the difference of the rates at the end of the step and beside it. size: u u. */
static void apply(gb_sim *sim, const double *u, double size, double *out) {
    const gb_model *model = sim->model;
    const double *end = sim->k + (size_t)sim->method->stages * (size_t)model->n_total;
    const double scale = LENGTH / (sqrt(size) * sim->head->options.rtol), inverse = 1.0 / scale;
    for (int b = 0; b < model->n_padded; b += GB_PAD) {
        *(gb_block *)(void *)(sim->z2 + b) = *gb_block_at(sim->z + b) + scale * *gb_block_at(u + b);
    }
    gb_rates(sim, 0, &sim->lanes, sim->method->stages, sim->z2, out);
    sim->head->counts.rhs_calls++;
    for (int b = 0; b < model->n_padded; b += GB_PAD) {
        *(gb_block *)(void *)(out + b) = inverse * (*gb_block_at(out + b) - *gb_block_at(end + b));
    }
}

/* The modulus of the larger root from the products of u, v = J u and w = J v. */
static double larger_root(double uu, double uv, double vv, double uw, double vw) {
    const double det = uu * vv - uv * uv;
    if (!(det > 1e-10 * uu * vv)) { /* u is along an eigenvector */
        return sqrt(vv / uu);
    }
    const double p = (uu * vw - uv * uw) / det, q = (uv * vw - vv * uw) / det, under = 0.25 * p * p - q;
    return under > 0.0 ? 0.5 * fabs(p) + sqrt(under) : sqrt(q);
}

/* 1/length, 0 where it is 0 or none; squared: the square of the length. */
static double unit(double squared) {
    return squared > 0.0 && squared < HUGE_VAL ? 1.0 / sqrt(squared) : 0.0;
}

/* The direction of this look in u, and its square: what the last one left, and a little of what tells two rates at the
 * end of the step apart, each of length 1. */
static double direction(const gb_sim *sim, double *u, double *apart) {
    const gb_model *model = sim->model;
    const double *end = sim->k + (size_t)sim->method->stages * (size_t)model->n_total, *last = end - model->n_total;
    for (int i = 0; i < model->n_padded; i++) {
        apart[i] = end[i] - last[i];
    }
    const double left = unit(product(sim, u, u)), fast = MIXED * unit(product(sim, apart, apart));
    for (int i = 0; i < model->n_padded; i++) {
        u[i] = (left > 0.0 ? left * u[i] : 0.0) + (fast > 0.0 ? fast * apart[i] : 0.0);
    }
    return product(sim, u, u);
}

/* One turn of the iteration: |lambda|, 0: not known. */
static double fastest_rate(gb_sim *sim) {
    const gb_model *model = sim->model;
    const size_t total = (size_t)model->n_total;
    double *u = sim->control.fast, *v = sim->events.defect, *w = v + total;
    const double uu = direction(sim, u, v);
    if (!(uu > 0.0)) {
        return 0.0;
    }
    apply(sim, u, uu, v);
    const double vv = product(sim, v, v);
    if (!(vv > 0.0)) {
        return 0.0;
    }
    apply(sim, v, vv, w);
    const double rate = larger_root(uu, product(sim, u, v), vv, product(sim, u, w), product(sim, v, w));
    const double shorter = 1.0 / vv;
    for (int i = 0; i < model->n_padded; i++) {
        u[i] = shorter * w[i];
    }
    return rate < HUGE_VAL ? rate : 0.0;
}

double gb_log_reach(gb_sim *sim, double h) {
    struct gb_pace *control = &sim->head->control;
    const double reach = sim->method->reach, before = control->reach_rate;
    const double rate = fastest_rate(sim), found = h * rate;
    const int settled = fabs(rate - before) < 0.2 * before;
    const int other = before > 0.0 && control->reach_modes != sim->head->events.mode_hash;
    control->reach_modes = sim->head->events.mode_hash;
    control->reach_h = h;
    control->reach_rate = other ? gb_max(rate, before) : rate;
    control->reach_gap = settled ? (2 * control->reach_gap < SELDOM ? 2 * control->reach_gap : SELDOM)
                         : other ? OFTEN
                                 : 1;
    control->reach_at = sim->head->counts.steps + control->reach_gap;
    return found > SLACK * reach ? gb_rough_log2(found / reach) * (double)sim->method->error_order : -100.0;
}

void gb_reach_changed(gb_sim *sim) {
    struct gb_pace *control = &sim->head->control;
    if (gb_is_held_by_reach(sim, control->h_next)) {
        const long long soonest = control->reach_at - control->reach_gap + OFTEN;
        control->reach_at = soonest < control->reach_at ? soonest : control->reach_at;
    }
}

void gb_reach_anew(gb_sim *sim) {
    struct gb_pace *control = &sim->head->control;
    const long long soon = sim->head->counts.steps + BEGUN;
    if (soon < control->reach_at) {
        control->reach_at = soon;
        control->reach_gap = 1;
    }
}
