#include "gb_time_terms.h"
#include "gb_inputs.h"

int gb_time_terms(gb_sim *sim, int lanes, gb_lanes *at) {
    for (int l = lanes; l < GB_LANES; l++) {
        at->t[l] = at->t[lanes - 1];
    }
    if (sim->inputs.n_moving > 0) {
        const int code = gb_input_lanes(sim, lanes, at->t, at->u);
        if (code != GB_DONE) {
            return code;
        }
    }
    if (sim->model->n_time_terms > 0) {
        sim->model->time_terms(sim->par, sim->mode, lanes, at->t, at->u, at->time_terms);
    }
    return GB_DONE;
}

int gb_time_terms_at(gb_sim *sim, double t) {
    sim->instant.t[0] = t;
    return gb_time_terms(sim, 1, &sim->instant);
}
