#include "gb_follow.h"
#include "gb_rates.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

/* Scratch rows, behind the stages that dense output may still ask for. */
enum { STAGE = GB_STAGES - 3, RATE, SUM };

/* rate = f(t, y) */
static int rates(gb_sim *sim, double t, const double *y, double *rate) {
    const int code = gb_time_terms_at(sim, t);
    if (code == GB_DONE) {
        gb_rates(sim, 0, &sim->instant, 0, y, rate);
        sim->head->counts.rhs_calls++;
    }
    return code;
}

int gb_follow(gb_sim *sim, double time, int steps, double *state) {
    static const double part[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    const int n = sim->model->n;
    const double h = time / steps, t = sim->head->front.t1;
    double *stage = gb_scratch_row(sim, STAGE), *rate = gb_scratch_row(sim, RATE), *sum = gb_scratch_row(sim, SUM);
    int code = GB_DONE;
    memcpy(state, sim->y, sizeof(double) * (size_t)sim->model->n_total);
    memcpy(stage, state, sizeof(double) * (size_t)sim->model->n_total);
    for (int step = 0; step < steps && code == GB_DONE; step++) {
        memset(sum, 0, sizeof(double) * (size_t)n);
        for (int k = 0; k < 4 && code == GB_DONE; k++) {
            for (int j = 0; j < n; j++) {
                stage[j] = state[j] + (k > 0 ? part[k] * h * rate[j] : 0.0);
            }
            code = rates(sim, t + (step + part[k]) * h, stage, rate);
            for (int j = 0; j < n; j++) {
                sum[j] += weight[k] * rate[j];
            }
        }
        for (int j = 0; j < n; j++) {
            state[j] += h * sum[j];
        }
    }
    return code == GB_DONE ? gb_time_terms_at(sim, t + time) : code;
}

int gb_follow_functions(gb_sim *sim, double time, int steps, double *state, double *s) {
    const int code = gb_follow(sim, time, steps, state);
    if (code == GB_DONE) {
        sim->model->event_functions(sim->par, sim->mode, sim->instant.time_terms, state, s);
    }
    return code;
}

int gb_follow_finite(gb_sim *sim, double time, int steps, double *state) {
    int code = gb_follow(sim, time, steps, state);
    while (code == GB_DONE && time > 0.0 && !(gb_taint(state, sim->model->n_padded) == 0.0)) {
        time *= 0.25;
        code = gb_follow(sim, time, steps, state);
    }
    return code;
}
