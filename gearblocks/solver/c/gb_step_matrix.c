#include "gb_step_matrix.h"
#include "gb_constraint_state.h"
#include "gb_evaluate.h"
#include "gb_inputs.h"

const gb_pattern *gb_pattern_of(const gb_sim *sim) {
    return sim->model->pattern;
}

void gb_step_matrix_sizes(const gb_sim *sim, int *n_kinematic, int *n_massless, int *n_kinematic_terms) {
    *n_kinematic = sim->model->n_kinematic;
    *n_massless = sim->model->n_massless;
    *n_kinematic_terms = sim->model->n_kinematic_terms;
}

int gb_step_matrix_at(gb_sim *sim, const gb_point *at, const double *y, double g, double *diag, double *lower,
                      double *upper, double *kinematic_terms) {
    const gb_model *model = sim->model;
    const double *mode = at->mode ? at->mode : sim->mode;
    if (!model->pattern) {
        return GB_ERR_STATE;
    }
    const int code = gb_point_time_terms(sim, at);
    if (code == GB_DONE) {
        mode = at->mode ? gb_modes_with_active_set(sim, mode, sim->instant.time_terms, y) : mode;
        model->rhs(sim->par, mode, sim->instant.time_terms, y, sim->z2);
        model->step_matrix(sim->par, mode, sim->instant.time_terms, y, sim->z2, g, diag, lower, upper, kinematic_terms);
    }
    gb_input_broadcast(sim);
    return code;
}

int gb_step_matrix_right_side(const gb_sim *sim, const double *kinematic_terms, double g, const double *r,
                              double *out) {
    if (!sim->model->pattern) {
        return GB_ERR_STATE;
    }
    sim->model->right_side(sim->par, kinematic_terms, g, r, out);
    return GB_DONE;
}

int gb_kinematic_rates(const gb_sim *sim, const double *kinematic_terms, const double *x, double *out) {
    if (!sim->model->pattern) {
        return GB_ERR_STATE;
    }
    sim->model->kinematic_rates(sim->par, kinematic_terms, x, out);
    return GB_DONE;
}
