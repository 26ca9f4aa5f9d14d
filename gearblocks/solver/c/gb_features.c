#include "gb_features.h"
#include "gb_dense_output.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

/* How far G may move in one step, and how far a step that is chosen by it moves it; the least part of a step. */
static const double MOST = 0.5, CHOSEN = 0.4, LEAST = 1e-3;

static double bend(double x, int bounded) {
    return bounded ? 3.0 * x / sqrt(x * x + 4.0) : x;
}

/* x from x0 at rate v (dx/dtheta): theta at which G has moved by `move`, or HUGE_VAL. */
static double reached(double x0, double v, double move, int bounded) {
    const double g = bend(x0, bounded) + (v > 0.0 ? move : -move);
    const double x = bounded ? 2.0 * g / sqrt(9.0 - g * g) : g;
    return (bounded && fabs(g) >= 3.0) || v == 0.0 ? HUGE_VAL : (x - x0) / v;
}

/* The features at the start, in the middle and at the end of the step. */
static int sample(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const int n = model->n_features;
    double *at = sim->scratch.features;
    sim->head->front.t0 = sim->head->front.t1;
    sim->head->front.h = h;
    gb_dense_hermite(sim);
    const int code = gb_time_terms_at(sim, sim->head->front.t0 + 0.5 * h);
    if (code == GB_DONE) {
        for (int b = 0; b < model->n_padded; b += GB_PAD) {
            const double *r = sim->rows + b;
            *(gb_block *)(void *)(sim->z2 + b) =
                *gb_block_at(sim->y0 + b) +
                0.5 * (*gb_block_at(r) + 0.5 * (*gb_block_at(r + model->n_total) +
                                                0.5 * *gb_block_at(r + (size_t)2 * (size_t)model->n_total)));
        }
        model->features(sim->par, sim->mode, sim->lanes.time_terms, sim->y0, at);
        model->features(sim->par, sim->mode, sim->instant.time_terms, sim->z2, at + n);
        model->features(sim->par, sim->mode, sim->lanes.time_terms + sim->method->stages, sim->z, at + 2 * n);
    }
    return code;
}

double gb_features_part(gb_sim *sim, double h) {
    const int n = sim->model->n_features;
    const double *at = sim->scratch.features;
    double part = 1.0, next = HUGE_VAL;
    if (sample(sim, h) != GB_DONE) {
        return 1.0;
    }
    for (int i = 0; i < n; i++) {
        const int bounded = sim->model->bounded_feature[i];
        const double x0 = at[i], x1 = at[n + i], x2 = at[2 * n + i];
        const double one = fabs(bend(x1, bounded) - bend(x0, bounded)),
                     two = fabs(bend(x2, bounded) - bend(x1, bounded));
        if (one + two > MOST) {
            part = gb_min(part, one > CHOSEN ? 0.5 * reached(x0, x1 - x0, CHOSEN, bounded)
                                             : 0.5 + 0.5 * reached(x1, x2 - x1, CHOSEN - one, bounded));
        }
        next = gb_min(next, 0.5 * h * reached(x2, x2 - x1, CHOSEN, bounded));
    }
    if (part < 1.0) {
        sim->head->front.h = 0.0;
        sim->head->front.have_dense = 0;
        return gb_max(part, LEAST);
    }
    sim->head->control.h_feature = next < HUGE_VAL ? next : 0.0;
    return 1.0;
}
