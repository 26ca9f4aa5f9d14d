/* Lossy ties: what they lose depends on the direction in which they slide and on the sign of the force that they carry,
 * and both on what they lose. Every combination is tried; one must hold true. */
#include "gb_internal.h"
#include "gb_lock.h"
#include "gb_locks.h"

int gb_has_lossy(const gb_sim *sim) {
    int found = 0;
    for (int i = 0; i < sim->model->n_locks; i++) {
        found = found || sim->model->locks[i].kind == GB_LOSS;
    }
    return found;
}

/* Options of a lossy tie: 0 at rest; else the direction in which it slides and the sign of the force that it carries.
 */
static void take_option(gb_sim *sim, int i, int option) {
    const gb_lock *loss = &sim->model->locks[i], *tie = &sim->model->locks[loss->partner];
    sim->lock_state[i] = option == 0 ? GB_CANDIDATE : GB_SLIDES;
    sim->mode[loss->slip] = option == 0 ? 0.0 : option <= 2 ? 1.0 : -1.0;
    sim->mode[tie->slip] = option % 2 == 0 ? -1.0 : 1.0;
}

static int is_option(const gb_sim *sim, int i, int option) {
    const gb_lock *loss = &sim->model->locks[i], *tie = &sim->model->locks[loss->partner];
    const double direction = option <= 2 ? 1.0 : -1.0, sign = option % 2 == 0 ? -1.0 : 1.0;
    if (sim->base_state[i] != GB_CANDIDATE) {
        const int left = sim->due[tie->slip] != 0.0 && sim->base_sign[i] == sign;
        return option > 0 && sim->base_mode[i] == direction && !left;
    }
    return option > 0 || !sim->released[i];
}

/* What was assumed about a lossy tie is what came of it. */
static int holds_true(gb_sim *sim, int i) {
    const gb_lock *loss = &sim->model->locks[i], *tie = &sim->model->locks[loss->partner];
    const double carried = gb_weighed_force(sim, loss->partner);
    double size;
    const double rate = gb_weighed_rate(sim, i, &size);
    if (sim->lock_state[i] == GB_CANDIDATE) {
        const double held = gb_weighed_force(sim, i);
        const double excess = gb_lock_loss_excess(sim->limit + 5 * i, carried, held);
        sim->mode[tie->slip] = carried >= 0.0 ? 1.0 : -1.0;
        return excess <= 1e-10 * (fabs(held) + fabs(carried));
    }
    const int j = loss->partner;
    const double response = fabs(sim->response[j * sim->model->n_locks + j]);
    const int fits = sim->mode[tie->slip] * carried * response >= -gb_rate_rounding(sim, j, 0.0);
    return fits &&
           (sim->base_state[i] != GB_CANDIDATE || sim->mode[loss->slip] * rate >= -gb_rate_rounding(sim, i, size));
}

/* Keeps the modes and slip accelerations of a solution; 1: another one was kept before. */
static int keep_solution(gb_sim *sim, int known) {
    const gb_model *model = sim->model;
    int other = 0;
    for (int i = 0; i < model->n_locks; i++) {
        double size;
        const double rate = gb_weighed_rate(sim, i, &size);
        other = other || (known && fabs(rate - sim->best_rate[i]) >
                                       1e3 * gb_rate_rounding(sim, i, size + fabs(sim->best_rate[i])));
        if (!known) {
            sim->best_rate[i] = rate;
            sim->best_state[i] = sim->lock_state[i];
            sim->best_mode[i] = sim->mode[model->locks[i].slip];
        }
    }
    return other;
}

/* All lossy ties are at rest. */
static int all_rest(const gb_sim *sim) {
    int rest = 1;
    for (int i = 0; i < sim->model->n_locks; i++) {
        rest = rest && (sim->model->locks[i].kind != GB_LOSS || sim->lock_state[i] == GB_CANDIDATE);
    }
    return rest;
}

/* Every combination of options of the lossy ties; the one that holds true is taken. */
int gb_weigh_lossy(gb_sim *sim) {
    const gb_model *model = sim->model;
    int n_found = 0, last = -1, code = GB_DONE;
    for (int i = 0; i < model->n_locks; i++) {
        const gb_lock *lock = &model->locks[i];
        sim->base_state[i] = sim->lock_state[i];
        sim->base_mode[i] = sim->mode[lock->slip];
        sim->base_sign[i] = lock->kind == GB_LOSS ? sim->mode[model->locks[lock->partner].slip] : 0.0;
        sim->option[i] = 0;
        last = lock->kind == GB_LOSS ? i : last;
    }
    for (int more = 1; more && code == GB_DONE;) {
        int wanted = 1;
        for (int i = 0; i < model->n_locks; i++) {
            wanted = wanted && (model->locks[i].kind != GB_LOSS || is_option(sim, i, sim->option[i]));
        }
        for (int i = 0; i < model->n_locks && wanted; i++) {
            sim->lock_state[i] = sim->base_state[i];
            if (model->locks[i].kind != GB_TIE) {
                sim->mode[model->locks[i].slip] = sim->base_mode[i];
            }
        }
        for (int i = 0; i < model->n_locks && wanted; i++) {
            if (model->locks[i].kind == GB_LOSS) {
                take_option(sim, i, sim->option[i]);
            }
        }
        code = wanted ? gb_weigh(sim) : GB_DONE;
        for (int i = 0; i < model->n_locks && wanted; i++) {
            wanted = model->locks[i].kind != GB_LOSS || holds_true(sim, i);
        }
        if (wanted && code == GB_DONE && keep_solution(sim, n_found++ > 0)) {
            return gb_fail(sim, GB_ERR_LOSS, model->locks[last].slip, sim->head->t1, 2.0);
        }
        more = 0;
        if (wanted && all_rest(sim)) {
            break; /* nothing begins to slide that can stay at rest */
        }
        for (int i = 0; i < model->n_locks && !more; i++) {
            if (model->locks[i].kind == GB_LOSS) {
                sim->option[i] = (sim->option[i] + 1) % 5;
                more = sim->option[i] != 0;
            }
        }
    }
    if (code == GB_DONE && n_found == 0) {
        return gb_fail(sim, GB_ERR_LOSS, model->locks[last].slip, sim->head->t1, 0.0);
    }
    for (int i = 0; i < model->n_locks && code == GB_DONE; i++) {
        sim->lock_state[i] = sim->best_state[i];
        sim->mode[model->locks[i].slip] = sim->best_mode[i];
    }
    return code;
}
