#include "gb_rosenbrock.h"
#include "gb_active_set.h"
#include "gb_implicit_angles.h"
#include "gb_rates.h"
#include "gb_report.h"
#include "gb_sparse_ldu.h"
#include "gb_stage_modes.h"
#include "gb_step_constraints.h"
#include "gb_vector.h"

/* Part of a step in which the rates are differenced in time: rounding and truncation are of equal weight there. */
static const double SHARE = 1e-4;

enum { INSTANTS = 2 }; /* of a method, beside its stages */

void gb_kinematic_links(gb_sim *sim) {
    const gb_model *model = sim->model;
    const gb_pattern *p = model->pattern;
    double *mark = sim->implicit.work, *named = sim->implicit.inverse, *one = sim->z, *two = sim->z2;
    if (!p) {
        return;
    }
    gb_colours(p, sim->implicit.colour);
    for (int c = 0; c < sim->implicit.n_colours; c++) {
        int *link = sim->implicit.link + (size_t)c * (size_t)model->n_kinematic;
        for (int u = 0; u < p->n; u++) {
            mark[u] = sim->implicit.colour[u] == c ? 1.0 : 0.0;
            named[u] = mark[u] * (u + 1);
        }
        model->kinematic_rates(sim->par, sim->implicit.kinematic_terms, mark, one);
        model->kinematic_rates(sim->par, sim->implicit.kinematic_terms, named, two);
        for (int i = 0; i < model->n_kinematic; i++) {
            link[i] = one[i] != 0.0 ? (int)(two[i] / one[i] - 0.5) : -1;
            sim->implicit.gain[(size_t)c * (size_t)model->n_kinematic + (size_t)i] = 1.0 / fabs(one[i]);
        }
    }
    memset(sim->z, 0, sizeof(double) * (size_t)model->n_total);
    memset(sim->z2, 0, sizeof(double) * (size_t)model->n_total);
}

void gb_least_scales(gb_sim *sim) {
    const gb_model *model = sim->model;
    double *restrict floor = sim->control.least_scale;
    for (int i = 0; i < model->n; i++) {
        floor[i] = HUGE_VAL;
    }
    for (int c = 0; c < sim->implicit.n_colours; c++) {
        const int *restrict link = sim->implicit.link + (size_t)c * (size_t)model->n_kinematic;
        const double *restrict gain = sim->implicit.gain + (size_t)c * (size_t)model->n_kinematic;
        for (int i = 0; i < model->n_kinematic; i++) {
            const int at = model->n_kinematic + link[i];
            if (link[i] >= 0 && at < model->n) {
                floor[at] = gb_min(floor[at], gb_max(sim->control.largest[i], sim->control.natural_scale[i]) * gain[i]);
            }
        }
    }
    for (int i = 0; i < model->n; i++) {
        floor[i] = floor[i] < HUGE_VAL ? floor[i] : 0.0;
    }
}

double gb_rosenbrock_time_step(double from, double h) {
    return gb_max(SHARE * h, 1e4 * DBL_EPSILON * fabs(from));
}

int gb_rosenbrock_lanes(const gb_sim *sim, double from, double h, double *t) {
    if (sim->model->n_time_terms == 0) {
        return 0;
    }
    for (int i = 0; i < INSTANTS; i++) {
        t[i] = from + sim->method->instants[i] * h;
    }
    t[INSTANTS] = from + SHARE * h;
    t[INSTANTS + 1] = from + 2.0 * SHARE * h;
    return INSTANTS + 2;
}

/* Time terms a SHARE and two SHAREs of the step behind the front along their tangent, from all that is known of them in
 * the step: a difference over so short a time would be that of their rounding. */
static void follow_tangent(gb_sim *sim, int lane) {
    const double *weight = sim->method->time_slope;
    for (int i = 0; i < sim->model->n_time_terms; i++) {
        double *term = sim->lanes.time_terms + (size_t)i * GB_LANES, slope = 0.0;
        for (int l = 1; l < GB_LANES; l++) {
            slope += weight[l] * (term[l] - term[0]);
        }
        if (slope - slope == 0.0) { /* else it stays as it is there: a term may have a pole where its law ends */
            term[lane] = term[0] + SHARE * slope;
            term[lane + 1] = term[0] + 2.0 * SHARE * slope;
        }
    }
}

/* h df/dt at the front, from a difference of second order. */
static void slope_in_time(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int lane = sim->method->all_stages + INSTANTS;
    double *first = sim->k + (size_t)GB_SLOPE * (size_t)model->n_total, *second = sim->z2;
    if (model->n_time_terms == 0) {
        return;
    }
    follow_tangent(sim, lane);
    gb_rates(sim, 0, &sim->lanes, lane, sim->y0, first);
    gb_rates(sim, 0, &sim->lanes, lane + 1, sim->y0, second);
    sim->head->counts.rhs_calls += 2;
    for (int i = 0; i < model->n_padded; i++) {
        first[i] = (2.0 * (first[i] - sim->k1[i]) - 0.5 * (second[i] - sim->k1[i])) / SHARE;
    }
}

/* k = gamma (I - g J)^-1 k, in the first n entries. With active constraints J is that of the constrained
 * motion. */
static void solve_stage(gb_sim *sim, double *k) {
    const gb_model *model = sim->model;
    const int kinematic = model->n_kinematic, n = gb_n_active_rows(sim);
    const double gamma = sim->method->gamma, g = gamma * sim->implicit.h;
    double *x = model->n_massless > 0 ? sim->implicit.unknown : k + kinematic, *rates = sim->z2;
    gb_wanted_slips(sim, k);
    model->right_side(sim->par, sim->implicit.kinematic_terms, g, k, sim->implicit.unknown);
    gb_solve(model->pattern, sim->implicit.inverse, sim->implicit.lower, sim->implicit.upper, sim->implicit.unknown,
             sim->implicit.work, x);
    if (n > 0) {
        gb_constrain_answer(sim, x);
    }
    model->kinematic_rates(sim->par, sim->implicit.kinematic_terms, x, rates);
    for (int i = 0; i < kinematic; i++) {
        k[i] = gamma * k[i] + g * rates[i];
    }
    if (model->n_massless > 0) {
        memcpy(k + kinematic, x, sizeof(double) * (size_t)(model->n - kinematic));
    }
}

/* The matrix of a step of size h from the front, factored. */
static int factor(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const double gamma = sim->method->gamma;
    model->step_matrix(sim->par, sim->mode, sim->lanes.time_terms, sim->y0, sim->k1, gamma * h, sim->implicit.diag,
                       sim->implicit.lower, sim->implicit.upper, sim->implicit.kinematic_terms);
    sim->head->counts.jacobians++;
    sim->implicit.h = h;
    gb_hold_speeds(sim);
    const gb_ties ties = {sim->implicit.tie_place, sim->implicit.tie_gain};
    const int bad = gb_factor(model->pattern, sim->implicit.tied ? &ties : NULL, gamma, sim->implicit.diag,
                              sim->implicit.lower, sim->implicit.upper, sim->implicit.inverse);
    if (bad < 0) {
        gb_factor_constraints(sim);
    }
    return bad < 0
               ? GB_DONE
               : gb_fail(sim, GB_ERR_SINGULAR, model->n_kinematic + bad, sim->head->front.t1, sim->implicit.diag[bad]);
}

/* The sums of stage j (a constant) over those before it: z = y0 + h sum a K, and in z2 what its right side has beside
 * the rates. */
GB_INLINE void sums_of(const gb_sim *sim, int j, double h) {
    const double *a = sim->method->stage[j][0], *c = sim->method->stage[j][1], *k = sim->k, *y0 = sim->y0;
    const double weight = sim->model->n_time_terms > 0 ? sim->method->slope[j] : 0.0;
    const size_t total = (size_t)sim->model->n_total;
    const int padded = sim->model->n_padded;
    double *z = sim->z, *z2 = sim->z2;
    for (int b = 0; b < padded; b += GB_PAD) {
        gb_block state = a[0] * *gb_block_at(k + b), right = c[0] * *gb_block_at(k + b);
        for (int i = 1; i < j; i++) {
            const gb_block one = *gb_block_at(k + (size_t)i * total + b);
            state += a[i] * one;
            right += c[i] * one;
        }
        if (weight != 0.0) {
            right += weight * *gb_block_at(k + GB_SLOPE * total + b);
        }
        *(gb_block *)(void *)(z + b) = *gb_block_at(y0 + b) + h * state;
        *(gb_block *)(void *)(z2 + b) = right;
    }
}

static void sum_stages(const gb_sim *sim, int j, double h) {
    switch (j) {
    case 1:
        sums_of(sim, 1, h);
        break;
    case 2:
        sums_of(sim, 2, h);
        break;
    case 3:
        sums_of(sim, 3, h);
        break;
    case 4:
        sums_of(sim, 4, h);
        break;
    case 5:
        sums_of(sim, 5, h);
        break;
    case 6:
        sums_of(sim, 6, h);
        break;
    case 7:
        sums_of(sim, 7, h);
        break;
    default:
        sums_of(sim, j, h);
    }
}

/* k = f + weight more. */
static void add(const gb_sim *sim, const double *f, double weight, const double *more, double *k) {
    for (int b = 0; b < sim->model->n_padded; b += GB_PAD) {
        *(gb_block *)(void *)(k + b) = *gb_block_at(f + b) + weight * *gb_block_at(more + b);
    }
}

/* The states at a node of the quadrature. */
static double *node(const gb_sim *sim, int i) {
    return sim->k + (size_t)(GB_SPARE + i) * (size_t)sim->model->n_total;
}

int gb_rosenbrock_stages(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const gb_method *method = sim->method;
    const int total = model->n_total, padded = model->n_padded;
    const int code = factor(sim, h);
    if (code != GB_DONE) {
        return code;
    }
    slope_in_time(sim);
    if (!sim->head->options.locate) {
        gb_stage_modes_begin(sim, method->all_stages + (model->n_time_terms > 0 ? INSTANTS + 2 : 0));
    }
    if (model->n_time_terms > 0) {
        add(sim, sim->k1, method->slope[0], sim->k + (size_t)GB_SLOPE * (size_t)total, sim->k);
    } else {
        gb_copy(sim->k, sim->k1, padded);
    }
    solve_stage(sim, sim->k);
    for (int j = 1; j < method->stages; j++) {
        double *k = sim->k + (size_t)j * (size_t)total;
        sum_stages(sim, j, h);
        if (sim->head->options.locate) {
            gb_rates(sim, 0, &sim->lanes, j, sim->z, k);
        } else {
            gb_stage_rates(sim, j, 0, sim->z, k);
        }
        add(sim, k, 1.0, sim->z2, k);
        solve_stage(sim, k);
    }
    const double *const from[] = {sim->y0, sim->y0, sim->y0}, sizes[] = {h, h, h};
    double *const out[] = {sim->z, node(sim, 0), node(sim, 1)};
    gb_combine_all(1 + GB_NODES, method->points, method->stages, sim->k, total, padded, from, sizes, out);
    sim->head->counts.rhs_calls += method->stages - 1;
    return GB_DONE;
}

void gb_rosenbrock_quadratures(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const gb_method *method = sim->method;
    const int total = model->n_total, padded = model->n_padded;
    if (model->n_quadratures == 0) {
        return;
    }
    gb_copy(sim->k + padded, sim->k1 + padded, total - padded);
    for (int c = 0; c < model->n_wrapped; c++) {
        const int i = model->wrapped[c].state;
        sim->k[i] = sim->k1[i];
    }
    for (int i = 0; i < GB_NODES; i++) {
        const int j = method->stages + 1 + i;
        double *k = sim->k + (size_t)j * (size_t)total;
        if (sim->head->options.locate) {
            gb_rates(sim, 1, &sim->lanes, j, node(sim, i), k);
        } else {
            gb_stage_rates(sim, j, 1, node(sim, i), k);
        }
        sim->head->counts.rhs_calls++;
    }
    gb_combine(&method->quadratures[0], sim->k, total, padded, total, sim->y0, h, sim->z);
    gb_implicit_angles(sim, 1.0, h, sim->z);
}

void gb_rosenbrock_response(gb_sim *sim, double *change) {
    solve_stage(sim, change);
}
