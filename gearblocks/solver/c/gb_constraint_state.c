#include "gb_constraint_state.h"
#include "gb_rates.h"
#include "gb_report.h"
#include "gb_vector.h"

int gb_is_active(const gb_sim *sim, int i) {
    return sim->mode[sim->model->constraints[i].active] > 0.5;
}

int gb_is_stop(const gb_sim *sim, int i) {
    return sim->model->constraints[i].kind == GB_STOP;
}

int gb_is_unbounded(const gb_sim *sim, int i) {
    const double *bounds = sim->constraints.bounds + 5 * i;
    return sim->model->constraints[i].kind != GB_LOSS && bounds[0] <= -HUGE_VAL && bounds[1] >= HUGE_VAL;
}

int gb_is_blocked(const gb_sim *sim, int i, double direction) {
    const double *bounds = sim->constraints.bounds + 5 * i;
    const int endless = direction < 0.0 ? bounds[1] >= HUGE_VAL : bounds[0] <= -HUGE_VAL;
    return endless && sim->model->constraints[i].kind == GB_FRICTION;
}

int gb_touches(const gb_sim *sim, int i) {
    const gb_constraint *constraint = &sim->model->constraints[i];
    return gb_is_active(sim, i) || sim->events.pending[constraint->slip] != 0.0 ||
           sim->events.armed[constraint->slip] == -1.0 || sim->events.s[constraint->slip] <= 0.0;
}

int gb_passes_a_stop(const gb_sim *sim, double unit) {
    for (int i = 0; i < sim->model->n_constraints; i++) {
        const int gap = sim->model->constraints[i].slip;
        const int moves = fabs(sim->constraints.slip[i]) > sim->constraints.slip_rounding[i];
        if (gb_is_stop(sim, i) && !gb_is_active(sim, i) && moves &&
            sim->events.s[gap] < -unit * sim->events.located[gap]) {
            return 1;
        }
    }
    return 0;
}

int gb_is_engaged(const gb_sim *sim, int i) {
    const gb_constraint *constraint = &sim->model->constraints[i];
    if (constraint->kind != GB_FRICTION) {
        return 1;
    }
    if (constraint->free < 0) {
        return sim->constraints.bounds[5 * i + 4] > 0.0;
    }
    if (constraint->free >=
        sim->model->n_event_functions) { /* time alone tells: at the instant of its switch the engagement is 0 */
        return sim->mode[constraint->free] < 0.5;
    }
    return sim->mode[constraint->free] < 0.5 &&
           (sim->head->events.n_sliding > 0 || sim->events.armed[constraint->free] != 0.0 ||
            sim->constraints.bounds[5 * i + 4] > 0.0);
}

void gb_size_rows(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_constraints; i++) {
        sim->constraints.row_size[i] = 0.0;
        model->constraint_row(sim->par, sim->mode, sim->instant.time_terms, sim->y, i, 0, sim->constraints.row);
        for (int k = 0; k < model->n_speeds; k++) {
            sim->constraints.row_size[i] += fabs(sim->constraints.row[k]);
        }
        sim->constraints.row_size[i] = gb_max(sim->constraints.row_size[i], 1.0);
    }
}

void gb_factor_active_set(gb_sim *sim, double *mode, const double *time_terms, const double *y) {
    sim->panel.known = 0;
    sim->head->events.forces_agreed = 0;
    if (sim->model->n_constraints > 0) {
        sim->model->factor_active_set(sim->par, mode, time_terms, y);
    }
}

void gb_read_bounds(gb_sim *sim, const double *y) {
    sim->model->force_bounds(sim->par, sim->mode, sim->instant.time_terms, y, sim->constraints.bounds);
    for (int c = 0; c < sim->model->n_constraints && sim->head->events.n_sliding > 0; c++) {
        if (sim->model->constraints[c].kind != GB_LOSS && (gb_rests(sim, c) || gb_holds_by_mean(sim, c))) {
            sim->constraints.bounds[5 * c] = -HUGE_VAL;
            sim->constraints.bounds[5 * c + 1] = HUGE_VAL;
        }
    }
}

const double *gb_modes_with_active_set(gb_sim *sim, const double *mode, const double *time_terms, const double *y) {
    const gb_model *model = sim->model;
    if (model->n_constraints == 0) {
        return mode;
    }
    memcpy(sim->constraints.full_mode, mode, sizeof(double) * (size_t)model->n_switches);
    model->factor_active_set(sim->par, sim->constraints.full_mode, time_terms, y);
    return sim->constraints.full_mode;
}

int gb_slips_are_exact(const gb_sim *sim) {
    return *gb_active_at(sim->model->constraint_rows, sim->mode + sim->model->n_switches).has_answer;
}

int gb_project_velocities(gb_sim *sim, const double *time_terms) {
    const gb_model *model = sim->model;
    if (model->n_constraints == 0 || sim->mode[model->n_switches] == 0.0) {
        return 0;
    }
    const int first = model->n - model->n_speeds;
    double most = 0.0, size = 0.0;
    for (int i = first; i < model->n; i++) {
        sim->z2[i] = sim->y[i];
    }
    model->project_velocities(sim->par, sim->mode, time_terms, sim->y);
    for (int i = first; i < model->n; i++) {
        most = gb_max(most, fabs(sim->y[i] - sim->z2[i]));
        size = gb_max(size, fabs(sim->y[i]));
    }
    return most > 1e-14 * size;
}

double gb_largest_speed(const gb_sim *sim, const double *y) {
    double size = 0.0;
    for (int i = sim->model->n - sim->model->n_speeds; i < sim->model->n; i++) {
        size = gb_max(size, fabs(y[i]));
    }
    return size;
}

void gb_slips_now(gb_sim *sim) {
    const gb_model *model = sim->model;
    const double size = gb_largest_speed(sim, sim->y);
    model->slips(sim->par, sim->mode, sim->instant.time_terms, sim->y, NULL, sim->constraints.slip);
    for (int i = 0; i < model->n_constraints; i++) {
        sim->constraints.slip_rounding[i] = 64.0 * DBL_EPSILON * size * sim->constraints.row_size[i];
    }
}

gb_delassus gb_delassus_of(const gb_sim *sim) {
    const gb_delassus W = {sim->model->n_constraints, sim->model->constraint_rows->pattern, sim->constraints.delassus};
    return W;
}

int gb_solve_problem(gb_sim *sim, int coupled) {
    const gb_coupled_bounds bounds = {sim->constraints.on, sim->constraints.lo_slope, sim->constraints.hi_slope, 0};
    const gb_lcp problem = {gb_delassus_of(sim),
                            sim->constraints.in,
                            coupled ? &bounds : NULL,
                            sim->constraints.room,
                            sim->model->constraint_rows->shares,
                            NULL};
    if (!gb_lcp_solve(&problem, sim->constraints.right, sim->constraints.lo, sim->constraints.hi,
                      sim->constraints.force)) {
        int first = 0;
        while (!sim->constraints.in[first]) {
            first++;
        }
        return gb_fail(sim, GB_ERR_BRANCH, sim->model->constraints[first].slip, sim->head->front.t1,
                       sim->constraints.right[first]);
    }
    return GB_DONE;
}

int gb_refuse_contradiction(gb_sim *sim, double noise) {
    const struct gb_constraints *c = &sim->constraints;
    const gb_delassus W = gb_delassus_of(sim);
    double most = 0.0;
    for (int i = 0; i < W.n; i++) {
        most = c->in[i] ? gb_max(most, fabs(c->right[i])) : most;
    }
    for (int i = 0; i < W.n; i++) {
        const int endless = c->lo[i] <= -HUGE_VAL || c->hi[i] >= HUGE_VAL;
        if (c->in[i] && endless && c->force[i] > c->lo[i] && c->force[i] < c->hi[i]) {
            double size = fabs(c->right[i]);
            const double left = c->right[i] + gb_delassus_product(&W, i, c->force, &size);
            if (fabs(left) > 1e-4 * most + 1e-12 * size + noise * c->row_size[i]) {
                return gb_fail(sim, GB_ERR_BRANCH, sim->model->constraints[i].slip, sim->head->front.t1, left);
            }
        }
    }
    return GB_DONE;
}
