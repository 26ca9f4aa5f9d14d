#include "gb_sliding_outputs.h"
#include "gb_constraint_state.h"
#include "gb_rates.h"

int gb_has_shares(const gb_model *model, const double *mode) {
    for (int i = 0; i < model->n_event_functions; i++) {
        if (mode[i] != floor(mode[i])) {
            return 1;
        }
    }
    return 0;
}

/* One term of the mean: rates (into z2) or outputs in the modes of sliding.mode, `share` of them. */
static void add_mean(double *sum, const double *value, const double *below, double share, int n) {
    for (int i = 0; i < n; i++) {
        sum[i] += below ? share * (value[i] - below[i]) : value[i];
    }
}

/* Rates (with `rate` given: outputs there) in modes of which switch `above` is one higher (-1: none). */
static const double *value_in(gb_sim *sim, const double *mode, int above, const gb_lanes *at, int lane, const double *y,
                              const double *rate, double *value) {
    const gb_model *model = sim->model;
    double *own = sim->sliding.mode;
    for (int i = 0; i < model->n_switches; i++) {
        own[i] = i < model->n_event_functions ? floor(mode[i]) : mode[i];
    }
    if (above >= 0) {
        own[above] += 1.0;
    }
    const double *terms = gb_terms_above(sim, at, lane);
    if (model->output_time_terms) {
        gb_lanes *lanes = &sim->sliding.lanes;
        model->output_time_terms(sim->par, own, 1, lanes->t, lanes->u, lanes->time_terms);
    }
    const double *full = gb_modes_with_active_set(sim, own, terms, y);
    if (rate) {
        model->outputs(sim->par, full, terms, y, rate, value);
    } else {
        model->rhs_full(sim->par, full, terms, y, value);
    }
    return value;
}

void gb_outputs_with_shares(gb_sim *sim, const double *mode, const gb_lanes *at, int lane, const double *y,
                            double *out) {
    const gb_model *model = sim->model;
    double *below = sim->sliding.rates, *above = below + model->n_total;
    double *const sums[] = {sim->z2, out}, *const values[] = {below, sim->sliding.outputs};
    double *const seconds[] = {above, sim->sliding.outputs + model->n_outputs};
    const int lengths[] = {model->n_total, model->n_outputs};
    for (int pass = 0; pass < 2; pass++) {
        const double *rate = pass == 0 ? NULL : sim->z2;
        memset(sums[pass], 0, sizeof(double) * (size_t)lengths[pass]);
        const double *first = value_in(sim, mode, -1, at, lane, y, rate, values[pass]);
        add_mean(sums[pass], first, NULL, 1.0, lengths[pass]);
        for (int i = 0; i < model->n_event_functions; i++) {
            const double share = mode[i] - floor(mode[i]);
            if (share > 0.0) {
                add_mean(sums[pass], value_in(sim, mode, i, at, lane, y, rate, seconds[pass]), first, share,
                         lengths[pass]);
            }
        }
    }
}
