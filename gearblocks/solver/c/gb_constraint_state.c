#include "gb_constraint_state.h"
#include "gb_constraint_rows.h"
#include "gb_report.h"
#include "gb_vector.h"

int gb_is_stuck(const gb_sim *sim, int i) {
    return sim->mode[sim->model->locks[i].hold] > 0.5;
}

int gb_is_stop(const gb_sim *sim, int i) {
    return sim->model->locks[i].kind == GB_STOP;
}

int gb_is_unlimited(const gb_sim *sim, int i) {
    const double *limit = sim->constraints.bounds + 5 * i;
    return sim->model->locks[i].kind != GB_LOSS && limit[0] <= -HUGE_VAL && limit[1] >= HUGE_VAL;
}

int gb_touches(const gb_sim *sim, int i) {
    const gb_lock *lock = &sim->model->locks[i];
    return gb_is_stuck(sim, i) || sim->events.pending[lock->slip] != 0.0 || sim->events.armed[lock->slip] == -1.0 ||
           sim->events.s[lock->slip] <= 0.0;
}

int gb_does_rub(const gb_sim *sim, int i) {
    const gb_lock *lock = &sim->model->locks[i];
    if (lock->kind != GB_FRICTION) {
        return 1;
    }
    if (lock->free < 0) {
        return sim->constraints.bounds[5 * i + 4] > 0.0;
    }
    if (lock->free >= sim->model->n_surfaces) { /* time alone tells: at the instant of its switch the engagement is 0 */
        return sim->mode[lock->free] < 0.5;
    }
    return sim->mode[lock->free] < 0.5 &&
           (sim->events.armed[lock->free] != 0.0 || sim->constraints.bounds[5 * i + 4] > 0.0);
}

void gb_size_locks(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_locks; i++) {
        sim->constraints.row_size[i] = 0.0;
        model->grip(sim->par, sim->mode, sim->instant.time_terms, sim->y, i, 0, sim->constraints.row);
        for (int k = 0; k < model->n_speeds; k++) {
            sim->constraints.row_size[i] += fabs(sim->constraints.row[k]);
        }
        sim->constraints.row_size[i] = gb_max(sim->constraints.row_size[i], 1.0);
    }
}

void gb_remember(gb_sim *sim, double *mode, const double *tau, const double *y) {
    if (sim->model->n_locks > 0) {
        sim->model->remember(sim->par, mode, tau, y);
    }
}

const double *gb_full_modes(gb_sim *sim, const double *mode, const double *tau, const double *y) {
    const gb_model *model = sim->model;
    if (model->n_locks == 0) {
        return mode;
    }
    memcpy(sim->constraints.full_mode, mode, sizeof(double) * (size_t)model->n_switches);
    model->remember(sim->par, sim->constraints.full_mode, tau, y);
    return sim->constraints.full_mode;
}

int gb_project(gb_sim *sim, const double *tau) {
    const gb_model *model = sim->model;
    if (model->n_locks == 0 || sim->mode[model->n_switches] == 0.0) {
        return 0;
    }
    const int first = model->n - model->n_speeds;
    double most = 0.0, size = 0.0;
    for (int i = first; i < model->n; i++) {
        sim->z2[i] = sim->y[i];
    }
    model->project(sim->par, sim->mode, tau, sim->y);
    for (int i = first; i < model->n; i++) {
        most = gb_max(most, fabs(sim->y[i] - sim->z2[i]));
        size = gb_max(size, fabs(sim->y[i]));
    }
    return most > 1e-14 * size;
}

void gb_slips_now(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int first = model->n - model->n_speeds;
    model->slips(sim->par, sim->mode, sim->instant.time_terms, sim->y, NULL, sim->constraints.slip);
    double size = 0.0;
    for (int i = first; i < model->n; i++) {
        size = gb_max(size, fabs(sim->y[i]));
    }
    for (int i = 0; i < model->n_locks; i++) {
        sim->constraints.slip_rounding[i] = 64.0 * DBL_EPSILON * size * sim->constraints.row_size[i];
    }
}

int gb_solve_problem(gb_sim *sim, int count) {
    const int n = sim->model->n_locks, *index = sim->constraints.index;
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < count; j++) {
            sim->constraints.matrix[i * count + j] = sim->constraints.delassus[index[i] * n + index[j]];
        }
    }
    if (!gb_lock_box(count, sim->constraints.matrix, sim->constraints.right, sim->constraints.lo, sim->constraints.hi,
                     sim->constraints.force)) {
        return gb_fail(sim, GB_ERR_BRANCH, sim->model->locks[index[0]].slip, sim->head->front.t1,
                       sim->constraints.right[0]);
    }
    return GB_DONE;
}

int gb_refuse_tie_up(gb_sim *sim, int count) {
    const double *b = sim->constraints.right, *x = sim->constraints.force;
    double most = 0.0;
    for (int i = 0; i < count; i++) {
        most = gb_max(most, fabs(b[i]));
    }
    for (int i = 0; i < count; i++) {
        double left = b[i], size = fabs(b[i]);
        for (int j = 0; j < count; j++) {
            const double part = sim->constraints.matrix[i * count + j] * x[j];
            left += part;
            size += fabs(part);
        }
        const int unlimited = sim->constraints.lo[i] <= -HUGE_VAL && sim->constraints.hi[i] >= HUGE_VAL;
        if (unlimited && fabs(left) > 1e-4 * most + 1e-12 * size) {
            const int lock = sim->constraints.index[i];
            return gb_fail(sim, GB_ERR_BRANCH, sim->model->locks[lock].slip, sim->head->front.t1, left);
        }
    }
    return GB_DONE;
}
