#include "gb_grip.h"
#include "gb_constraint_state.h"
#include "gb_modes.h"
#include "gb_report.h"

/* Takes these modes of constraint c. */
static void take(gb_sim *sim, int c, double active, double direction) {
    const gb_constraint *of = &sim->model->constraints[c];
    gb_log(sim, of->slip, 0, sim->mode[of->slip], direction);
    gb_set_mode(sim, of->active, active, 0);
    gb_set_mode(sim, of->slip, direction, 0);
    sim->events.armed[of->slip] = -direction;
    sim->events.armed[of->active] = 0.0;
}

static void factor(gb_sim *sim) {
    gb_factor_active_set(sim, sim->mode, sim->instant.time_terms, sim->y);
    gb_mode_limits(sim);
    gb_rehash(sim);
}

int gb_grip_again(gb_sim *sim) {
    const gb_model *model = sim->model;
    int count = 0;
    if (model->n_constraints > 0) {
        gb_slips_now(sim);
    }
    for (int c = 0; c < model->n_constraints; c++) {
        const gb_constraint *of = &model->constraints[c];
        const int met =
            sim->events.pending[of->slip] != 0.0 || fabs(sim->constraints.slip[c]) <= sim->constraints.slip_rounding[c];
        sim->constraints.released[c] =
            met && of->kind == GB_FRICTION && !gb_is_active(sim, c) && sim->mode[of->slip] != 0.0;
        if (sim->constraints.released[c]) {
            sim->constraints.shrink[c] = sim->mode[of->slip];
            take(sim, c, 1.0, 0.0);
            count++;
        }
    }
    if (count > 0) {
        factor(sim);
        gb_project_velocities(sim, sim->instant.time_terms);
    }
    return count;
}

void gb_let_go_again(gb_sim *sim) {
    for (int c = 0; c < sim->model->n_constraints; c++) {
        if (sim->constraints.released[c]) {
            take(sim, c, 0.0, sim->constraints.shrink[c]);
        }
    }
    factor(sim);
}
