#include "gb_dense_output.h"
#include "gb_angle_wrapping.h"
#include "gb_implicit_angles.h"
#include "gb_report.h"
#include "gb_runge_kutta.h"
#include "gb_vector.h"

/* The three rows of the cubic Hermite polynomial in the entries [from, to). */
static void hermite_rows(const gb_sim *sim, int from, int to) {
    const int total = sim->model->n_total;
    const double h = sim->head->front.h;
    const double *k1 = sim->k, *k2 = sim->k + (size_t)sim->method->stages * (size_t)total;
    double *r1 = sim->rows, *r2 = r1 + total, *r3 = r2 + total;
    gb_combine(&sim->method->a[sim->method->stages], sim->k, total, from, to, sim->zero, h, r1);
    for (int b = from; b < to; b += GB_PAD) {
        for (int l = b; l < b + GB_PAD; l++) {
            r2[l] = h * k1[l] - r1[l];
            r3[l] = (r1[l] - h * k2[l]) - r2[l];
        }
    }
}

/* The rows beyond them. */
static void further_rows(const gb_sim *sim, int from, int to) {
    const int total = sim->model->n_total;
    for (int m = 3; m < sim->method->rows; m++) {
        gb_combine(&sim->method->d[m], sim->k, total, from, to, sim->zero, sim->head->front.h,
                   sim->rows + (size_t)m * (size_t)total);
    }
}

/* The rows of an implicit method: sums of its stages, or of the rates at the nodes for the quadratures. */
static void summed_rows(const gb_sim *sim) {
    const int total = sim->model->n_total;
    const double h = sim->head->front.h, hs[] = {h, h, h, h}, *const none[] = {NULL, NULL, NULL, NULL};
    double *const out[] = {sim->rows, sim->rows + total, sim->rows + (size_t)2 * (size_t)total,
                           sim->rows + (size_t)3 * (size_t)total};
    gb_combine_all(GB_NODES + 2, sim->method->inside, sim->method->stages, sim->k, total, sim->model->n_padded, none,
                   hs, out);
}

static void summed_rows_of_quadratures(const gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int m = 0; m < sim->method->rows; m++) {
        gb_combine(&sim->method->quadratures[m], sim->k, model->n_total, model->n_padded, model->n_total, sim->zero,
                   sim->head->front.h, sim->rows + (size_t)m * (size_t)model->n_total);
    }
}

void gb_dense_hermite(gb_sim *sim) {
    if (sim->head->front.have_dense == 0 && sim->method->gamma > 0.0) {
        summed_rows(sim);
        if (sim->model->n_wrapped > 0) {
            gb_wrapping_rows(sim, 0, sim->method->rows);
        }
        sim->head->front.have_dense = 2;
    } else if (sim->head->front.have_dense == 0) {
        hermite_rows(sim, 0, sim->model->n_padded);
        if (sim->model->n_wrapped > 0) {
            gb_wrapping_rows(sim, 0, 3);
        }
        sim->head->front.have_dense = 1;
    }
}

int gb_dense_complete(gb_sim *sim) {
    const gb_model *model = sim->model;
    const gb_method *method = sim->method;
    if (sim->head->front.have_dense == 2) {
        return GB_DONE;
    }
    gb_dense_hermite(sim);
    if (sim->head->front.have_dense == 2) {
        return GB_DONE;
    }
    if (sim->head->options.locate) {
        gb_run_extra_stages(sim, sim->head->front.h);
    } else {
        gb_run_extra_stages_unlocated(sim, sim->head->front.h);
    }
    for (int j = method->stages + 1; j < method->all_stages; j++) {
        const double *k = sim->k + (size_t)j * (size_t)model->n_total;
        if (!(gb_taint(k, model->n_total) == 0.0)) {
            return gb_check_finite(sim, GB_ERR_NAN_RATE, k, model->n_total, 0, sim->lanes.t[j]);
        }
    }
    further_rows(sim, 0, model->n_padded);
    if (model->n_wrapped > 0) {
        gb_wrapping_rows(sim, 3, method->rows);
    }
    sim->head->front.have_dense = 2;
    return GB_DONE;
}

int gb_dense_quadratures(gb_sim *sim) {
    if (sim->head->front.have_quadratures || sim->head->front.h == 0.0) {
        return GB_DONE;
    }
    if (gb_dense_complete(sim) != GB_DONE) {
        return sim->head->report.code;
    }
    if (sim->method->gamma > 0.0) {
        summed_rows_of_quadratures(sim);
        gb_implicit_angle_rows(sim);
    } else {
        hermite_rows(sim, sim->model->n_padded, sim->model->n_total);
        further_rows(sim, sim->model->n_padded, sim->model->n_total);
    }
    sim->head->front.have_quadratures = 1;
    return GB_DONE;
}

static void horner(const gb_sim *sim, double theta, int to, double *out) {
    const int total = sim->model->n_total, last = sim->method->rows - 1;
    const double up = theta, down = 1.0 - theta;
    for (int b = 0; b < to; b += GB_PAD) {
        double sum[GB_PAD];
        for (int l = 0; l < GB_PAD; l++) {
            sum[l] = sim->rows[(size_t)last * (size_t)total + (size_t)(b + l)];
        }
        for (int m = last - 1; m >= 0; m--) {
            const double *row = sim->rows + (size_t)m * (size_t)total + b;
            const double factor = m % 2 == 0 ? down : up;
            for (int l = 0; l < GB_PAD; l++) {
                sum[l] = row[l] + factor * sum[l];
            }
        }
        for (int l = 0; l < GB_PAD; l++) {
            out[b + l] = sim->y0[b + l] + up * sum[l];
        }
    }
}

void gb_dense_rates(const gb_sim *sim, double theta, double *states, double *rates) {
    const int total = sim->model->n_total, last = sim->method->rows - 1;
    for (int b = 0; b < sim->model->n_padded; b += GB_PAD) {
        gb_block p = *gb_block_at(sim->rows + (size_t)last * (size_t)total + b), d = {0.0};
        for (int m = last - 1; m >= 0; m--) {
            const double factor = m % 2 == 0 ? 1.0 - theta : theta, sign = m % 2 == 0 ? -1.0 : 1.0;
            d = factor * d + sign * p;
            p = *gb_block_at(sim->rows + (size_t)m * (size_t)total + b) + factor * p;
        }
        *(gb_block *)(void *)(states + b) = *gb_block_at(sim->y0 + b) + theta * p;
        *(gb_block *)(void *)(rates + b) = p + theta * d;
    }
}

void gb_dense_states(const gb_sim *sim, double theta, double *out) {
    horner(sim, theta, sim->model->n_padded, out);
}

void gb_dense_all(const gb_sim *sim, double t, double *out) {
    const gb_head *head = sim->head;
    if (t >= head->front.t1 || !head->front.have_quadratures) {
        memcpy(out, sim->y, sizeof(double) * (size_t)sim->model->n_total);
        return;
    }
    horner(sim, (t - head->front.t0) / head->front.h, sim->model->n_total, out);
}

void gb_dense_cut(gb_sim *sim, double theta) {
    const gb_method *method = sim->method;
    const gb_model *model = sim->model;
    gb_weights weights = {0, {0}, {0.0}};
    double w[GB_STAGES];
    gb_dense_states(sim, theta, sim->y);
    for (int j = 0; j < GB_STAGES; j++) {
        w[j] = method->dense[method->rows - 1][j];
    }
    for (int m = method->rows - 2; m >= 0; m--) {
        const double factor = m % 2 == 0 ? 1.0 - theta : theta;
        for (int j = 0; j < GB_STAGES; j++) {
            w[j] = method->dense[m][j] + factor * w[j];
        }
    }
    for (int j = 0; j < method->all_stages; j++) {
        if (method->full[j]) {
            weights.index[weights.count] = j;
            weights.value[weights.count++] = w[j];
        }
    }
    gb_combine(&weights, sim->k, model->n_total, model->n_padded, model->n_total, sim->y0, theta * sim->head->front.h,
               sim->y);
    if (method->gamma > 0.0) {
        gb_implicit_angles(sim, theta, sim->head->front.h, sim->y);
    }
    sim->head->front.t1 = theta > 0.0 ? sim->head->front.t0 + theta * sim->head->front.h : sim->head->front.t0;
}
