/* The stages of a step and their weighted sums, where most of the time goes. */
#include "gb_combine.h"

/* All stages of the step from y0, and the new state z with its tail. */
void gb_run_stages(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const gb_method *method = sim->method;
    const int total = model->n_total, padded = model->n_padded;
    for (int j = 1; j < method->stages; j++) {
        gb_combine(&method->a[j], sim->k, total, 0, padded, sim->y0, h, sim->z);
        (method->full[j] ? model->rhs_full : model->rhs)(sim->par, sim->mode, sim->tau + j, sim->z,
                                                         sim->k + (size_t)j * (size_t)total);
    }
    gb_combine(&method->a[method->stages], sim->k, total, 0, total, sim->y0, h, sim->z);
    sim->head->rhs_calls += method->stages - 1;
}

/* The stages that only dense output needs. */
void gb_run_extra_stages(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const gb_method *method = sim->method;
    for (int j = method->stages + 1; j < method->all_stages; j++) {
        gb_combine(&method->a[j], sim->k, model->n_total, 0, model->n_padded, sim->y0, h, sim->z2);
        model->rhs_full(sim->par, sim->mode, sim->tau + j, sim->z2, sim->k + (size_t)j * (size_t)model->n_total);
        sim->head->rhs_calls++;
    }
}

static double largest_of(double *worst) {
    for (int half = GB_PAD / 2; half > 0; half /= 2) {
        for (int l = 0; l < half; l++) {
            worst[l] = gb_max(worst[l], worst[l + half]);
        }
    }
    return worst[0];
}

/* max |sum_j e_j k_j| weight over the states, without the factor h. */
static double error_norm(const gb_sim *sim, const gb_weights *e) {
    double worst[GB_PAD] = {0.0};
    for (int b = 0; b < sim->model->n_padded; b += GB_PAD) {
        double error[GB_PAD];
        gb_combine(e, sim->k + b, sim->model->n_total, 0, GB_PAD, sim->zero, 1.0, error);
        for (int l = 0; l < GB_PAD; l++) {
            const double ratio = fabs(error[l]) * sim->weight[b + l];
            worst[l] = ratio > worst[l] ? ratio : worst[l];
        }
    }
    return largest_of(worst);
}

/* log2 to about 1e-3: enough for step sizes, quick, and the same bits on every machine. */
static double rough_log2(double x) {
    uint64_t bits;
    double m;
    memcpy(&bits, &x, sizeof bits);
    const double exponent = (double)(int)(bits >> 52) - 1023.0;
    bits = (bits & 0xfffffffffffffu) | 0x3ff0000000000000u;
    memcpy(&m, &bits, sizeof m);
    const double f = m - 1.0;
    return exponent + f * (1.4234 + f * (-0.5877 + f * 0.1643));
}

/* The same where the estimate is the last stage. */
static double last_norm(const gb_sim *sim) {
    const double *k = sim->k + (size_t)(sim->method->stages - 1) * (size_t)sim->model->n_total;
    double worst[GB_PAD] = {0.0};
    for (int b = 0; b < sim->model->n_padded; b += GB_PAD) {
        for (int l = 0; l < GB_PAD; l++) {
            const double ratio = fabs(k[b + l]) * sim->weight[b + l];
            worst[l] = ratio > worst[l] ? ratio : worst[l];
        }
    }
    return largest_of(worst);
}

/* log2 of the largest error of a state in units of its weight. */
double gb_log_error(const gb_sim *sim, double h) {
    const gb_method *method = sim->method;
    const double first = h * (method->gamma > 0.0 ? last_norm(sim) : error_norm(sim, &method->e[0]));
    if (!(first > 1e-30)) {
        return -100.0;
    }
    if (method->n_errors == 1) {
        return rough_log2(first);
    }
    const double second = h * error_norm(sim, &method->e[1]);
    return 2.0 * rough_log2(first) - 0.5 * rough_log2(first * first + 0.01 * second * second);
}
