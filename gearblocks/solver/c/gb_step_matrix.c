#include "gb_step_matrix.h"
#include "gb_constraint_state.h"
#include "gb_evaluate.h"
#include "gb_inputs.h"

const gb_pattern *gb_pattern_of(const gb_sim *sim) {
    return sim->model->pattern;
}

void gb_linear_sizes(const gb_sim *sim, int *n_simple, int *n_hidden, int *n_kept) {
    *n_simple = sim->model->n_simple;
    *n_hidden = sim->model->n_hidden;
    *n_kept = sim->model->n_kept;
}

int gb_linear_matrix(gb_sim *sim, const gb_point *at, const double *y, double g, double *diag, double *lower,
                     double *upper, double *kept) {
    const gb_model *model = sim->model;
    const double *mode = at->mode ? at->mode : sim->mode;
    if (!model->pattern) {
        return GB_ERR_STATE;
    }
    const int code = gb_point_columns(sim, at);
    if (code == GB_DONE) {
        mode = at->mode ? gb_full_modes(sim, mode, sim->instant.time_terms, y) : mode;
        model->rhs(sim->par, mode, sim->instant.time_terms, y, sim->z2);
        model->jacobian(sim->par, mode, sim->instant.time_terms, y, sim->z2, g, diag, lower, upper, kept);
    }
    gb_input_broadcast(sim);
    return code;
}

int gb_linear_side(const gb_sim *sim, const double *kept, double g, const double *r, double *out) {
    if (!sim->model->pattern) {
        return GB_ERR_STATE;
    }
    sim->model->right_side(sim->par, kept, g, r, out);
    return GB_DONE;
}

int gb_linear_rates(const gb_sim *sim, const double *kept, const double *x, double *out) {
    if (!sim->model->pattern) {
        return GB_ERR_STATE;
    }
    sim->model->simple_rates(sim->par, kept, x, out);
    return GB_DONE;
}
