#include "gb_point.h"
#include "gb_constraint_state.h"
#include "gb_evaluate.h"
#include "gb_inputs.h"
#include "gb_report.h"

/* The modes that fit the event functions in s (state) and the time just after t, into `fit`. */
static void fit_modes(const gb_sim *sim, const double *mode, double t, double *fit) {
    const gb_model *model = sim->model;
    const double after = t + 4.0 * DBL_EPSILON * fabs(t) + 1e-290;
    for (int i = 0; i < model->n_switches; i++) {
        const double s = i < model->n_event_functions ? sim->events.s[i] : model->time_function(sim->par, i, after);
        fit[i] = sim->events.role[i] == GB_CONSTRAINED ? mode[i] : model->mode_at(sim->par, i, s);
    }
}

int gb_probe(gb_sim *sim, const gb_point *at, const double *y, double *dy, double *out, double *energy, double *fit,
             double *surface) {
    const gb_model *model = sim->model;
    const double *mode = at->mode ? at->mode : sim->mode;
    int code = sim->head->started || at->mode ? GB_DONE : gb_fail(sim, GB_ERR_STATE, 0, at->t, 0.0);
    if (code == GB_DONE) {
        code = gb_point_time_terms(sim, at);
    }
    if (code == GB_DONE) {
        double *rate = dy ? dy : sim->z2;
        mode = at->mode ? gb_modes_with_active_set(sim, mode, sim->instant.time_terms, y) : mode;
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
            model->event_functions(sim->par, mode, sim->instant.time_terms, y, sim->events.s);
            fit_modes(sim, mode, at->t, fit);
        }
        if (surface && model->n_switches > 0) {
            model->event_functions(sim->par, mode, sim->instant.time_terms, y, surface);
        }
    }
    gb_input_broadcast(sim);
    return code;
}

int gb_constraints_of(const gb_sim *sim, int *n_speeds, int *steady, int *offset) {
    const gb_model *model = sim->model;
    *n_speeds = model->n_speeds;
    *steady = model->constant_rows;
    for (int i = 0; i < model->n_constraints && offset; i++) {
        const gb_constraint *constraint = &model->constraints[i];
        const int numbers[] = {constraint->kind, constraint->slip, constraint->active, constraint->free};
        memcpy(offset + (size_t)4 * (size_t)i, numbers, sizeof numbers);
    }
    return model->n_constraints;
}

int gb_constraints_at(gb_sim *sim, const gb_point *at, const double *y, double *rows, double *effects, double *bounds,
                      double *force, double *violation, double *slip) {
    const gb_model *model = sim->model;
    const int code = gb_point_time_terms(sim, at);
    if (code == GB_DONE && model->n_constraints > 0) {
        const double *mode = at->mode ? gb_modes_with_active_set(sim, at->mode, sim->instant.time_terms, y) : sim->mode;
        for (int i = 0; i < model->n_constraints; i++) {
            model->constraint_row(sim->par, mode, sim->instant.time_terms, y, i, 0,
                                  rows + (size_t)i * (size_t)model->n_speeds);
            model->constraint_row(sim->par, mode, sim->instant.time_terms, y, i, 1,
                                  effects + (size_t)i * (size_t)model->n_speeds);
        }
        model->force_bounds(sim->par, mode, sim->instant.time_terms, y, bounds);
        model->constraint_forces(sim->par, mode, sim->instant.time_terms, y, force, violation);
        model->event_functions(sim->par, mode, sim->instant.time_terms, y, sim->events.s);
        model->slips(sim->par, mode, sim->instant.time_terms, y, NULL, slip);
        for (int i = 0; i < model->n_constraints; i++) {
            slip[i] = model->constraints[i].kind == GB_TIE ? slip[i] : sim->events.s[model->constraints[i].slip];
        }
    }
    gb_input_broadcast(sim);
    return code;
}
