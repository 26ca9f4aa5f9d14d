#include "gb_evaluate.h"
#include "gb_inputs.h"
#include "gb_rates.h"
#include "gb_report.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

int gb_point_time_terms(gb_sim *sim, const gb_point *at) {
    const gb_model *model = sim->model;
    const int code = at->input ? GB_DONE : gb_input_values(sim, at->t, sim->scratch.inputs);
    const double *value = at->input ? at->input : sim->scratch.inputs, *mode = at->mode ? at->mode : sim->mode;
    for (int l = 0; l < GB_LANES; l++) {
        sim->instant.t[l] = at->t;
        for (int i = 0; i < model->n_inputs; i++) {
            sim->instant.u[i * GB_LANES + l] = value[i];
        }
    }
    if (code == GB_DONE && model->n_time_terms > 0) {
        const int mean = at->means && model->mean_time_terms;
        (mean ? model->mean_time_terms : model->time_terms)(sim->par, mode, 1, sim->instant.t, sim->instant.u,
                                                            sim->instant.time_terms);
        if (!mean && model->output_time_terms) {
            model->output_time_terms(sim->par, mode, 1, sim->instant.t, sim->instant.u, sim->instant.time_terms);
        }
    }
    return code;
}

int gb_first_derivative(gb_sim *sim, const gb_lanes *at) {
    const gb_model *model = sim->model;
    gb_rates(sim, 1, at, 0, sim->y, sim->k1);
    sim->head->counts.rhs_calls++;
    if (!(gb_taint(sim->k1, model->n_total) == 0.0)) {
        return gb_check_finite(sim, GB_ERR_NAN_RATE, sim->k1, model->n_total, 0, sim->head->front.t1);
    }
    sim->head->front.have_k1 = 1;
    return GB_DONE;
}

int gb_event_functions_now(gb_sim *sim) {
    if (sim->model->n_event_functions > sim->model->n_affine) {
        const int code = gb_time_terms_at(sim, sim->head->front.t1);
        if (code != GB_DONE) {
            return code;
        }
    }
    sim->model->event_functions(sim->par, sim->mode, sim->instant.time_terms, sim->y, sim->events.s);
    return GB_DONE;
}
