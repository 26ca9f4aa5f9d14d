#include "gb_lossy_gear.h"
#include "gb_constraint_forces.h"
#include "gb_constraint_rows.h"
#include "gb_constraints.h"
#include "gb_report.h"

int gb_has_lossy(const gb_sim *sim) {
    int found = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        found = found || sim->model->constraints[i].kind == GB_LOSS;
    }
    return found;
}

/* Options of a lossy gear: 0 at rest; else the direction in which it slides and the sign of the force that it carries.
 */
static void take_option(gb_sim *sim, int i, int option) {
    const gb_constraint *loss = &sim->model->constraints[i], *tie = &sim->model->constraints[loss->partner];
    sim->constraints.decision[i] = option == 0 ? GB_CANDIDATE : GB_SLIDES;
    sim->mode[loss->slip] = option == 0 ? 0.0 : option <= 2 ? 1.0 : -1.0;
    sim->mode[tie->slip] = option % 2 == 0 ? -1.0 : 1.0;
}

static int is_option(const gb_sim *sim, int i, int option) {
    const gb_constraint *loss = &sim->model->constraints[i], *tie = &sim->model->constraints[loss->partner];
    const double direction = option <= 2 ? 1.0 : -1.0, sign = option % 2 == 0 ? -1.0 : 1.0;
    if (sim->lossy.base_decision[i] != GB_CANDIDATE) {
        const int left = sim->events.pending[tie->slip] != 0.0 && sim->lossy.base_sign[i] == sign;
        return option > 0 && sim->lossy.base_mode[i] == direction && !left;
    }
    return option > 0 || !sim->constraints.released[i];
}

/* What was assumed about a lossy gear is what came of it. */
static int holds_true(gb_sim *sim, int i) {
    const gb_constraint *loss = &sim->model->constraints[i], *tie = &sim->model->constraints[loss->partner];
    const double carried = gb_constraint_force(sim, loss->partner);
    double size;
    const double rate = gb_slip_acceleration(sim, i, &size);
    if (sim->constraints.decision[i] == GB_CANDIDATE) {
        const double force = gb_constraint_force(sim, i);
        const double violation = gb_loss_excess(sim->constraints.bounds + 5 * i, carried, force);
        sim->mode[tie->slip] = carried >= 0.0 ? 1.0 : -1.0;
        return violation <= 1e-10 * (fabs(force) + fabs(carried));
    }
    const int j = loss->partner;
    const double response = fabs(sim->constraints.delassus[j * sim->model->n_constraints + j]);
    const int fits = sim->mode[tie->slip] * carried * response >= -gb_acceleration_rounding(sim, j, 0.0);
    return fits && (sim->lossy.base_decision[i] != GB_CANDIDATE ||
                    sim->mode[loss->slip] * rate >= -gb_acceleration_rounding(sim, i, size));
}

/* Keeps the modes and slip accelerations of a solution; 1: another one was kept before. */
static int keep_solution(gb_sim *sim, int known) {
    const gb_model *model = sim->model;
    int other = 0;
    for (int i = 0; i < model->n_constraints; i++) {
        double size;
        const double rate = gb_slip_acceleration(sim, i, &size);
        other = other || (known && fabs(rate - sim->lossy.best_rate[i]) >
                                       1e3 * gb_acceleration_rounding(sim, i, size + fabs(sim->lossy.best_rate[i])));
        if (!known) {
            sim->lossy.best_rate[i] = rate;
            sim->lossy.best_decision[i] = sim->constraints.decision[i];
            sim->lossy.best_mode[i] = sim->mode[model->constraints[i].slip];
        }
    }
    return other;
}

/* All lossy gears are at rest. */
static int all_rest(const gb_sim *sim) {
    int rest = 1;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        rest = rest && (sim->model->constraints[i].kind != GB_LOSS || sim->constraints.decision[i] == GB_CANDIDATE);
    }
    return rest;
}

int gb_choose_lossy(gb_sim *sim) {
    const gb_model *model = sim->model;
    int n_found = 0, last = -1, code = GB_DONE;
    for (int i = 0; i < model->n_constraints; i++) {
        const gb_constraint *constraint = &model->constraints[i];
        sim->lossy.base_decision[i] = sim->constraints.decision[i];
        sim->lossy.base_mode[i] = sim->mode[constraint->slip];
        sim->lossy.base_sign[i] =
            constraint->kind == GB_LOSS ? sim->mode[model->constraints[constraint->partner].slip] : 0.0;
        sim->lossy.option[i] = 0;
        last = constraint->kind == GB_LOSS ? i : last;
    }
    for (int more = 1; more && code == GB_DONE;) {
        int wanted = 1;
        for (int i = 0; i < model->n_constraints; i++) {
            wanted = wanted && (model->constraints[i].kind != GB_LOSS || is_option(sim, i, sim->lossy.option[i]));
        }
        for (int i = 0; i < model->n_constraints && wanted; i++) {
            sim->constraints.decision[i] = sim->lossy.base_decision[i];
            if (model->constraints[i].kind != GB_TIE) {
                sim->mode[model->constraints[i].slip] = sim->lossy.base_mode[i];
            }
        }
        for (int i = 0; i < model->n_constraints && wanted; i++) {
            if (model->constraints[i].kind == GB_LOSS) {
                take_option(sim, i, sim->lossy.option[i]);
            }
        }
        code = wanted ? gb_choose_active_set(sim) : GB_DONE;
        for (int i = 0; i < model->n_constraints && wanted; i++) {
            wanted = model->constraints[i].kind != GB_LOSS || holds_true(sim, i);
        }
        if (wanted && code == GB_DONE && keep_solution(sim, n_found++ > 0)) {
            return gb_fail(sim, GB_ERR_LOSS, model->constraints[last].slip, sim->head->front.t1, 2.0);
        }
        more = 0;
        if (wanted && all_rest(sim)) {
            break; /* nothing begins to slide that can stay at rest */
        }
        for (int i = 0; i < model->n_constraints && !more; i++) {
            if (model->constraints[i].kind == GB_LOSS) {
                sim->lossy.option[i] = (sim->lossy.option[i] + 1) % 5;
                more = sim->lossy.option[i] != 0;
            }
        }
    }
    if (code == GB_DONE && n_found == 0) {
        return gb_fail(sim, GB_ERR_LOSS, model->constraints[last].slip, sim->head->front.t1, 0.0);
    }
    for (int i = 0; i < model->n_constraints && code == GB_DONE; i++) {
        sim->constraints.decision[i] = sim->lossy.best_decision[i];
        sim->mode[model->constraints[i].slip] = sim->lossy.best_mode[i];
    }
    return code;
}
