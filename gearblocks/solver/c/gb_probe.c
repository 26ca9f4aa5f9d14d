/* Looking at the laws at a point that the caller gives: for linear tools and static starts. Changes nothing of a run.
 */
#include "gb_internal.h"

/* The modes that fit the surfaces in s (state) and the time just after t, into `fit`. */
static void fit_modes(const gb_sim *sim, const double *mode, double t, double *fit) {
    const gb_model *model = sim->model;
    const double after = t + 4.0 * DBL_EPSILON * fabs(t) + 1e-290;
    for (int i = 0; i < model->n_switches; i++) {
        const double s = i < model->n_surfaces ? sim->s[i] : model->clock(sim->par, i, after);
        fit[i] = sim->role[i] == GB_LOCKED ? mode[i] : model->mode_at(sim->par, i, s);
    }
}

/* Inputs and time columns of a point, into tau_one. gb_input_broadcast puts the lanes of constant inputs right again.
 */
int gb_point_columns(gb_sim *sim, const gb_point *at) {
    const gb_model *model = sim->model;
    const int code = at->input ? GB_DONE : gb_input_values(sim, at->t, sim->z_input);
    const double *value = at->input ? at->input : sim->z_input, *mode = at->mode ? at->mode : sim->mode;
    for (int l = 0; l < GB_LANES; l++) {
        sim->t_one[l] = at->t;
        for (int i = 0; i < model->n_inputs; i++) {
            sim->u_one[i * GB_LANES + l] = value[i];
        }
    }
    if (code == GB_DONE && model->n_time > 0) {
        const int mean = at->means && model->means;
        (mean ? model->means : model->times)(sim->par, mode, 1, sim->t_one, sim->u_one, sim->tau_one);
        if (!mean && model->times_late) {
            model->times_late(sim->par, mode, 1, sim->t_one, sim->u_one, sim->tau_one);
        }
    }
    return code;
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
        mode = at->mode ? gb_full_modes(sim, mode, sim->tau_one, y) : mode;
        if (dy || (out && !at->rate)) {
            model->rhs_full(sim->par, mode, sim->tau_one, y, rate);
        }
        if (out) {
            model->outputs(sim->par, mode, sim->tau_one, y, at->rate ? at->rate : rate, out);
        }
        if (energy) {
            model->energies(sim->par, mode, sim->tau_one, y, energy);
        }
        if (fit && model->n_switches > 0) {
            model->surfaces(sim->par, mode, sim->tau_one, y, sim->s);
            fit_modes(sim, mode, at->t, fit);
        }
    }
    gb_input_broadcast(sim);
    return code;
}
