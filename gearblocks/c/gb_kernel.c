/* The weighted sums of a step, where most of the solver's own time goes.
 *
 * Each is written once over (method, sizes). For the usual case - the pair of order 8 on a train whose states and
 * tail fill one block each - the same lines are compiled a second time with all of these constant, so that the loops
 * over the tableau unroll. Both give the same bits.
 */
#include "gb_combine.h"
#include "gb_methods.h"

typedef struct shape {
    const gb_method *method;
    int padded, total;
} shape;

GB_INLINE void stages(gb_sim *sim, shape s, double h) {
    const gb_model *model = sim->model;
    double *const k = sim->k;
    GB_UNROLL
    for (int j = 1; j < s.method->stages; j++) {
        gb_combine(&s.method->a[j], k, s.total, 0, s.padded, sim->y0, h, sim->z);
        (s.method->full[j] ? model->rhs_full : model->rhs)(sim->par, sim->mode, sim->tau + j, sim->z,
                                                           k + (size_t)j * (size_t)s.total);
    }
    gb_combine(&s.method->a[s.method->stages], k, s.total, 0, s.total, sim->y0, h, sim->z);
}

GB_INLINE void extra_stages(gb_sim *sim, shape s, double h) {
    const gb_model *model = sim->model;
    double *const k = sim->k;
    GB_UNROLL
    for (int j = s.method->stages + 1; j < s.method->all_stages; j++) {
        gb_combine(&s.method->a[j], k, s.total, 0, s.padded, sim->y0, h, sim->z2);
        model->rhs_full(sim->par, sim->mode, sim->tau + j, sim->z2, k + (size_t)j * (size_t)s.total);
    }
}

GB_INLINE void further_rows(gb_sim *sim, shape s, double h, int from, int to) {
    GB_UNROLL
    for (int m = 3; m < s.method->rows; m++) {
        gb_combine(&s.method->d[m], sim->k, s.total, from, to, sim->zero, h, sim->rows + (size_t)m * (size_t)s.total);
    }
}

/* max |sum_j e_j k_j| weight, without the factor h. */
GB_INLINE double error_norm(const gb_sim *sim, const gb_weights *e, shape s) {
    double worst[GB_PAD] = {0.0};
    for (int b = 0; b < s.padded; b += GB_PAD) {
        double error[GB_PAD];
        gb_combine(e, sim->k + b, s.total, 0, GB_PAD, sim->zero, 1.0, error);
        for (int l = 0; l < GB_PAD; l++) {
            const double ratio = fabs(error[l]) * sim->weight[b + l];
            worst[l] = ratio > worst[l] ? ratio : worst[l];
        }
    }
    for (int half = GB_PAD / 2; half > 0; half /= 2) {
        for (int l = 0; l < half; l++) {
            worst[l] = gb_max(worst[l], worst[l + half]);
        }
    }
    return worst[0];
}

static int is_usual(const gb_sim *sim) {
    return sim->method == &sim->table[GB_DP8] && sim->model->n_padded == GB_PAD && sim->model->n_total == 2 * GB_PAD;
}

static const shape usual = {&gb_method_table[GB_DP8], GB_PAD, 2 * GB_PAD};

static shape shape_of(const gb_sim *sim) {
    const shape s = {sim->method, sim->model->n_padded, sim->model->n_total};
    return s;
}

/* All stages of the step from y0, and the new state z. */
void gb_run_stages(gb_sim *sim, double h) {
    if (is_usual(sim)) {
        stages(sim, usual, h);
    } else {
        stages(sim, shape_of(sim), h);
    }
    sim->head->rhs_calls += sim->method->stages - 1;
}

/* The stages that only dense output needs. */
void gb_run_extra_stages(gb_sim *sim, double h) {
    if (is_usual(sim)) {
        extra_stages(sim, usual, h);
    } else {
        extra_stages(sim, shape_of(sim), h);
    }
    sim->head->rhs_calls += sim->method->all_stages - sim->method->stages - 1;
}

/* The dense rows beyond the cubic, in the states or in the tail. */
void gb_further_rows(gb_sim *sim, double h, int tail) {
    const gb_model *model = sim->model;
    if (is_usual(sim) && !tail) {
        further_rows(sim, usual, h, 0, GB_PAD);
    } else {
        further_rows(sim, shape_of(sim), h, tail ? model->n_padded : 0, tail ? model->n_total : model->n_padded);
    }
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

/* log2 of the largest error of a state in units of its weight. */
double gb_log_error(const gb_sim *sim, double h) {
    const gb_method *method = sim->method;
    const shape s = shape_of(sim);
    double first, second = 0.0;
    if (is_usual(sim)) {
        first = error_norm(sim, &usual.method->e[0], usual);
        second = error_norm(sim, &usual.method->e[1], usual);
    } else {
        first = error_norm(sim, &method->e[0], s);
        second = method->n_errors > 1 ? error_norm(sim, &method->e[1], s) : 0.0;
    }
    first *= h;
    second *= h;
    if (!(first > 1e-30)) {
        return -100.0;
    }
    return method->n_errors == 1 ? rough_log2(first)
                                 : 2.0 * rough_log2(first) - 0.5 * rough_log2(first * first + 0.01 * second * second);
}
