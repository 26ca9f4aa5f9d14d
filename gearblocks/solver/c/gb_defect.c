#include "gb_defect.h"
#include "gb_dense_output.h"
#include "gb_error_control.h"
#include "gb_features.h"
#include "gb_massless_error.h"
#include "gb_rates.h"
#include "gb_rosenbrock.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

/* How many tolerances the error inside a step that moves no feature may have, by how much more a step that was looked
 * at is trusted at most, and after how many steps that are held back one is looked at again: fewest, and most. */
static const double DENSE = 4.0, MOST_TRUSTED = 2.0, OFTEN = 2.0, SELDOM = 32.0;

/* Where in the step the defect of massless speeds is looked at besides, as it passes zero elsewhere than at the other
 * point; and the part of the tolerances of states that they may be off by: from look to look such an error grows
 * faster. */
static const double OF_MASSLESS = 0.5, STRICTER = 0.5;

/* Of an implicit step of size h that moves a feature: log2 of the integral of its defect. */
static double log_integral(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const gb_method *method = sim->method;
    const gb_weights *w = &method->quadratures[0];
    double worst = 0.0, *rest = sim->events.defect;
    if (model->n_quadratures == 0 || !gb_moves_feature(sim, h)) {
        return -100.0;
    }
    for (int i = 0; i < model->n_padded; i++) {
        double sum = 0.0;
        for (int j = 0; j < w->count; j++) {
            const int at = w->index[j];
            sum += w->value[j] * (at == 0 ? sim->k1[i] : sim->k[(size_t)at * (size_t)model->n_total + (size_t)i]);
        }
        rest[i] = (sim->y0[i] - sim->z[i]) + h * sum;
    }
    gb_rosenbrock_response(sim, rest);
    for (int i = 0; i < model->n; i++) {
        worst = gb_max(worst, fabs(rest[i]) * sim->control.error_weight[i] / method->gamma);
    }
    return gb_rough_log2(worst + 1e-30);
}

int gb_slopes_at(gb_sim *sim, double theta, double h) {
    double *slope = sim->events.defect, *rate = slope + sim->model->n_total;
    if (gb_time_terms_at(sim, sim->head->front.t0 + theta * h) != GB_DONE) {
        return 0;
    }
    gb_dense_rates(sim, theta, sim->z2, slope);
    gb_rates(sim, 0, &sim->instant, 0, sim->z2, rate);
    sim->head->counts.rhs_calls++;
    return 1;
}

double gb_largest_defect(const gb_sim *sim, const double *d, double h) {
    double worst = 0.0;
    for (int i = 0; i < sim->model->n; i++) {
        const double rounding = 2e3 * DBL_EPSILON * gb_max(fabs(sim->events.defect[i]), h * fabs(sim->k1[i]));
        worst = gb_max(worst, (fabs(d[i]) - rounding) * sim->control.error_weight[i]);
    }
    return worst;
}

/* h times the defect at theta, in the place of the rates there; 0: the inputs cannot be had. */
static int defect_at(gb_sim *sim, double theta, double h) {
    double *slope = sim->events.defect, *rate = slope + sim->model->n_total;
    const int had = gb_slopes_at(sim, theta, h);
    for (int i = 0; i < sim->model->n && had; i++) {
        rate[i] = slope[i] - h * rate[i];
    }
    return had;
}

double gb_log_defect(gb_sim *sim, double h) {
    gb_head *head = sim->head;
    const double theta = sim->method->defect[0], allowed = gb_moves_feature(sim, h) ? 1.0 : DENSE;
    const double factor = sim->method->defect[1] / allowed, massless = 1.0 / (STRICTER * allowed);
    double worst = 0.0, *rate = sim->events.defect + sim->model->n_total;
    if (sim->method->gamma > 0.0) {
        return log_integral(sim, h);
    }
    if (!(factor > 0.0)) {
        return -100.0;
    }
    head->front.t0 = head->front.t1;
    head->front.h = h;
    if (gb_dense_complete(sim) == GB_DONE && defect_at(sim, theta, h)) {
        worst = gb_max(factor * gb_largest_defect(sim, rate, h), massless * gb_largest_massless_defect(sim, rate, h));
        if (sim->model->n_massless > 0 && defect_at(sim, OF_MASSLESS, h)) {
            worst = gb_max(worst, massless * gb_largest_massless_defect(sim, rate, h));
        }
    }
    const double error = gb_rough_log2(worst + 1e-30);
    if (error > 0.0) {
        head->front.h = 0.0;
        head->front.have_dense = 0;
    } else { /* and up to where it would be too large, by its order */
        const double room = gb_rough_exp2(-error / (double)sim->method->error_order);
        head->control.h_trusted = h * gb_max(gb_min(0.9 * room, MOST_TRUSTED), 1.0);
        /* A defect passes zero by chance, too: no more than twice as long as to this look. */
        head->control.defect_gap = gb_max(OFTEN, gb_min(gb_min(-error, SELDOM), 2.0 * head->control.defect_gap));
        head->control.defect_at = head->counts.steps + (long long)head->control.defect_gap;
    }
    return error;
}
