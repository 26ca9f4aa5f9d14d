#include "gb_stage_modes.h"

void gb_stage_modes_begin(gb_sim *sim, int lanes) {
    sim->unlocated.crossed = 0;
    sim->unlocated.lanes = lanes;
    memcpy(sim->unlocated.mode, sim->mode, sizeof(double) * sim->unlocated.n_carried);
}

int gb_stage_modes(gb_sim *sim, const gb_lanes *at, int lanes, int lane, const double *y) {
    const gb_model *model = sim->model;
    double *mode = sim->unlocated.mode;
    int last = model->n_event_functions > 0 ? 0 : -1;
    for (int round = 0; round < GB_FLIPS && last >= 0; round++) {
        last = -1;
        model->event_functions(sim->par, mode, at->time_terms + lane, y, sim->events.s);
        for (int i = 0; i < model->n_event_functions; i++) {
            if (sim->events.role[i] == GB_ORDINARY) {
                const double fit = model->mode_at(sim->par, i, sim->events.s[i]);
                last = fit != mode[i] ? i : last;
                mode[i] = fit;
            }
        }
        sim->unlocated.crossed |= last >= 0;
        if (last >= 0 && model->n_time_terms > 0) {
            model->time_terms(sim->par, mode, lanes, at->t, at->u, at->time_terms);
        }
    }
    return last;
}

void gb_stage_rates(gb_sim *sim, int lane, int full, const double *y, double *dy) {
    const gb_model *model = sim->model;
    gb_stage_modes(sim, &sim->lanes, sim->unlocated.lanes, lane, y);
    (full ? model->rhs_full : model->rhs)(sim->par, sim->unlocated.mode, sim->lanes.time_terms + lane, y, dy);
}
