#include "gb_tangent_step.h"
#include "gb_rates.h"
#include "gb_tangent_parameter.h"
#include "gb_time_terms.h"

static const double NEAR = 1e-4; /* of the size of a state: laws bend over a hundredth of it and less */

double gb_tangent_reach(const gb_sim *sim, const gb_tangent_room *room, const double *y, const double *v) {
    double most = 0.0, any = 0.0;
    for (int i = 0; i < sim->model->n; i++) {
        const double size = gb_max(gb_max(sim->control.largest[i], room->scale[i]), fabs(y[i]));
        any = gb_max(any, fabs(v[i]));
        most = size > 0.0 ? gb_max(most, fabs(v[i]) / size) : most;
    }
    return most > 0.0 ? NEAR / most : any > 0.0 ? NEAR / any : 0.0;
}

/* J v at y, into out. */
static void product(gb_sim *sim, const gb_tangent_room *room, int lane, const double *y, const double *v, double *out) {
    const int padded = sim->model->n_padded;
    const double reach = gb_tangent_reach(sim, room, y, v);
    memset(out, 0, sizeof(double) * (size_t)padded);
    for (int p = 0; p < GB_BESIDE && reach > 0.0; p++) {
        const double distance = gb_beside(p) * reach, weight = gb_beside_weight(p) / reach;
        for (int b = 0; b < padded; b++) {
            room->moved[b] = y[b] + distance * v[b];
        }
        gb_rates(sim, 0, &room->lanes, lane, room->moved, room->rates);
        for (int b = 0; b < padded; b++) {
            out[b] += weight * room->rates[b];
        }
    }
    sim->head->counts.rhs_calls += GB_BESIDE;
}

/* Time terms at the stages of a step of size h from t0. */
static int stage_terms(gb_sim *sim, const gb_tangent_room *room, double t0, double h) {
    gb_lanes lanes = room->lanes;
    for (int j = 0; j < sim->method->stages; j++) {
        lanes.t[j] = t0 + sim->method->c[j] * h;
    }
    memcpy(lanes.u, sim->lanes.u, sizeof(double) * (size_t)(GB_LANES * sim->model->n_inputs));
    return gb_time_terms(sim, sim->method->stages, &lanes);
}

int gb_tangents_step(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room) {
    const gb_method *method = sim->method;
    const int total = sim->model->n_total, padded = sim->model->n_padded;
    const size_t all = (size_t)method->stages * (size_t)total;
    const double t0 = sim->head->front.t0, h = sim->head->front.t1 - t0;
    if (!(h > 0.0) || tangents->count == 0) {
        return GB_DONE;
    }
    int code = stage_terms(sim, room, t0, h);
    if (code == GB_DONE && tangents->change) {
        code = gb_parameter_terms(sim, room, &room->lanes, method->stages);
    }
    for (int j = 0; j < method->stages && code == GB_DONE; j++) {
        const double *y = sim->y0;
        if (j > 0) {
            gb_combine(&method->a[j], room->slopes, total, 0, padded, sim->y0, h, room->state);
            y = room->state;
        }
        gb_rates(sim, 0, &room->lanes, j, y, room->slopes + (size_t)j * (size_t)total);
        for (int c = 0; c < tangents->count; c++) {
            double *rates = room->columns + (size_t)c * all;
            const double *v = tangents->columns + (size_t)c * (size_t)total;
            if (j > 0) {
                gb_combine(&method->a[j], rates, total, 0, padded, v, h, room->combined);
                v = room->combined;
            }
            product(sim, room, j, y, v, rates + (size_t)j * (size_t)total);
            if (tangents->change && c == tangents->count - 1) {
                gb_rates_by_parameter(sim, room, j, y, rates + (size_t)j * (size_t)total);
            }
        }
    }
    for (int c = 0; c < tangents->count && code == GB_DONE; c++) {
        double *v = tangents->columns + (size_t)c * (size_t)total;
        gb_combine(&method->a[method->stages], room->columns + (size_t)c * all, total, 0, padded, v, h, v);
    }
    sim->head->counts.rhs_calls += method->stages;
    return code;
}
