#include "gb_point.h"
#include "gb_constraint_state.h"
#include "gb_evaluate.h"
#include "gb_inputs.h"
#include "gb_report.h"

/* The modes that fit the surfaces in s (state) and the time just after t, into `fit`. */
static void fit_modes(const gb_sim *sim, const double *mode, double t, double *fit) {
    const gb_model *model = sim->model;
    const double after = t + 4.0 * DBL_EPSILON * fabs(t) + 1e-290;
    for (int i = 0; i < model->n_switches; i++) {
        const double s = i < model->n_surfaces ? sim->events.s[i] : model->clock(sim->par, i, after);
        fit[i] = sim->events.role[i] == GB_LOCKED ? mode[i] : model->mode_at(sim->par, i, s);
    }
}

int gb_probe(gb_sim *sim, const gb_point *at, const double *y, double *dy, double *out, double *energy, double *fit) {
    const gb_model *model = sim->model;
    const double *mode = at->mode ? at->mode : sim->mode;
    int code = sim->head->started ? GB_DONE : gb_fail(sim, GB_ERR_STATE, 0, at->t, 0.0);
    if (code == GB_DONE) {
        code = gb_point_columns(sim, at);
    }
    if (code == GB_DONE) {
        double *rate = dy ? dy : sim->z2;
        mode = at->mode ? gb_full_modes(sim, mode, sim->instant.time_terms, y) : mode;
        if (dy || (out && !at->rate)) {
            model->rhs_full(sim->par, mode, sim->instant.time_terms, y, rate);
        }
        if (out) {
            model->outputs(sim->par, mode, sim->instant.time_terms, y, at->rate ? at->rate : rate, out);
        }
        if (energy) {
            model->energies(sim->par, mode, sim->instant.time_terms, y, energy);
        }
        if (fit && model->n_switches > 0) {
            model->surfaces(sim->par, mode, sim->instant.time_terms, y, sim->events.s);
            fit_modes(sim, mode, at->t, fit);
        }
    }
    gb_input_broadcast(sim);
    return code;
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

int gb_locks_at(gb_sim *sim, const gb_point *at, const double *y, double *rows, double *pushes, double *limit,
                double *held, double *excess, double *slip) {
    const gb_model *model = sim->model;
    const int code = gb_point_columns(sim, at);
    if (code == GB_DONE && model->n_locks > 0) {
        const double *mode = at->mode ? gb_full_modes(sim, at->mode, sim->instant.time_terms, y) : sim->mode;
        for (int i = 0; i < model->n_locks; i++) {
            model->grip(sim->par, mode, sim->instant.time_terms, y, i, 0, rows + (size_t)i * (size_t)model->n_speeds);
            model->grip(sim->par, mode, sim->instant.time_terms, y, i, 1, pushes + (size_t)i * (size_t)model->n_speeds);
        }
        model->limits(sim->par, mode, sim->instant.time_terms, y, limit);
        model->holding(sim->par, mode, sim->instant.time_terms, y, held, excess);
        model->surfaces(sim->par, mode, sim->instant.time_terms, y, sim->events.s);
        for (int i = 0; i < model->n_locks; i++) {
            slip[i] = sim->events.s[model->locks[i].slip];
        }
    }
    gb_input_broadcast(sim);
    return code;
}
