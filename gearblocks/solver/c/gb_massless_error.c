#include "gb_massless_error.h"
#include "gb_error_control.h"
#include "gb_rates.h"
#include "gb_vector.h"

/* A massless speed stands in the rate of state i. */
static int has_massless_rate(const gb_sim *sim, int i) {
    const gb_model *model = sim->model;
    for (int c = 0; c < sim->implicit.n_colours; c++) {
        const int link = sim->implicit.link[(size_t)c * (size_t)model->n_kinematic + (size_t)i];
        if (link >= 0 && model->n_kinematic + link >= model->n) {
            return 1;
        }
    }
    return 0;
}

/* What counts as no error of the speed in the rate of state i. */
static double weight_of(const gb_sim *sim, int i) {
    return sim->head->options.rtol * sim->control.fastest_rate[i] + sim->control.noise[i];
}

double gb_log_massless_error(gb_sim *sim, double h, double log_error) {
    const gb_model *model = sim->model;
    const size_t total = (size_t)model->n_total;
    const double *end = sim->k + (size_t)sim->method->stages * total;
    double *rate = sim->k + (size_t)(GB_STAGES - 1) * total, *fastest = sim->control.fastest_rate;
    double size = 0.0, worst = 0.0;
    gb_combine(&sim->method->e[0], sim->k, model->n_total, 0, model->n_padded, sim->zero, h, sim->z2);
    for (int i = 0; i < model->n; i++) {
        size = gb_max(size, fabs(sim->z2[i]) * sim->control.error_weight[i]);
    }
    const double part = size > 0.0 ? gb_min(1.0, gb_rough_exp2(log_error) / size) : 0.0;
    for (int i = 0; i < model->n_padded; i++) {
        sim->z2[i] = sim->z[i] + part * sim->z2[i];
    }
    gb_rates(sim, 0, &sim->lanes, sim->method->stages, sim->z2, rate);
    sim->head->counts.rhs_calls++;
    for (int i = 0; i < model->n_kinematic; i++) {
        if (has_massless_rate(sim, i)) {
            fastest[i] = gb_max(fastest[i], gb_max(fabs(end[i]), fabs(sim->k1[i])));
            const double weight = weight_of(sim, i);
            worst = weight > 0.0 ? gb_max(worst, fabs(rate[i] - end[i]) / weight) : worst;
        }
    }
    return gb_rough_log2(worst + 1e-30);
}

double gb_largest_massless_defect(const gb_sim *sim, const double *d, double h) {
    double worst = 0.0;
    for (int i = 0; i < sim->model->n_kinematic && sim->model->n_massless > 0; i++) {
        const double weight = weight_of(sim, i);
        if (weight > 0.0 && has_massless_rate(sim, i)) {
            const double rounding = 2e3 * DBL_EPSILON * fabs(sim->events.defect[i]);
            worst = gb_max(worst, (fabs(d[i]) - rounding) / (h * weight));
        }
    }
    return worst;
}
