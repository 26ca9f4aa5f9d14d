/* The linear parts of a model at one instant, for tests and tools. */
#include "gb_internal.h"

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
        mode = at->mode ? gb_full_modes(sim, mode, sim->tau_one, y) : mode;
        model->rhs(sim->par, mode, sim->tau_one, y, sim->z2);
        model->jacobian(sim->par, mode, sim->tau_one, y, sim->z2, g, diag, lower, upper, kept);
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

int gb_locks_of(const gb_sim *sim, int *n_speeds, int *steady, int *place) {
    const gb_model *model = sim->model;
    *n_speeds = model->n_speeds;
    *steady = model->steady_locks;
    for (int i = 0; i < model->n_locks && place; i++) {
        const gb_lock *lock = &model->locks[i];
        const int numbers[] = {lock->kind, lock->slip, lock->hold, lock->free};
        memcpy(place + (size_t)4 * (size_t)i, numbers, sizeof numbers);
    }
    return model->n_locks;
}

int gb_modes(const gb_sim *sim, double *mode) {
    memcpy(mode, sim->mode, sizeof(double) * (size_t)sim->model->n_switches);
    return sim->head->started ? GB_DONE : GB_ERR_STATE;
}

int gb_locks_at(gb_sim *sim, const gb_point *at, const double *y, double *rows, double *pushes, double *limit,
                double *held, double *excess, double *slip) {
    const gb_model *model = sim->model;
    const int code = gb_point_columns(sim, at);
    if (code == GB_DONE && model->n_locks > 0) {
        const double *mode = at->mode ? gb_full_modes(sim, at->mode, sim->tau_one, y) : sim->mode;
        for (int i = 0; i < model->n_locks; i++) {
            model->grip(sim->par, mode, sim->tau_one, y, i, 0, rows + (size_t)i * (size_t)model->n_speeds);
            model->grip(sim->par, mode, sim->tau_one, y, i, 1, pushes + (size_t)i * (size_t)model->n_speeds);
        }
        model->limits(sim->par, mode, sim->tau_one, y, limit);
        model->holding(sim->par, mode, sim->tau_one, y, held, excess);
        model->surfaces(sim->par, mode, sim->tau_one, y, sim->s);
        for (int i = 0; i < model->n_locks; i++) {
            slip[i] = sim->s[model->locks[i].slip];
        }
    }
    gb_input_broadcast(sim);
    return code;
}
