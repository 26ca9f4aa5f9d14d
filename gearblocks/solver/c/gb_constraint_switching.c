#include "gb_constraint_switching.h"
#include "gb_constraint_forces.h"
#include "gb_constraint_rows.h"
#include "gb_constraint_state.h"
#include "gb_constraints.h"
#include "gb_evaluate.h"
#include "gb_impact.h"
#include "gb_lossy_gear.h"
#include "gb_modes.h"
#include "gb_report.h"
#include "gb_vector.h"

/* Mode for the events: 0 stuck, 1 forward, -1 backward, 2 free; of a stop 1 closed, 0 open. */
static double shown_mode(const gb_sim *sim, int i) {
    const gb_lock *lock = &sim->model->locks[i];
    if (lock->kind == GB_STOP || lock->kind == GB_TIE) {
        return sim->mode[lock->hold];
    }
    return gb_is_stuck(sim, i) ? 0.0 : sim->mode[lock->slip] == 0.0 ? 2.0 : sim->mode[lock->slip];
}

/* What each lock could do, by its slip alone; what slides gets its direction. */
static void sort_by_slip(gb_sim *sim, int impacted) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_locks; i++) {
        const gb_lock *lock = &model->locks[i];
        const double slip = sim->constraints.slip[i], rounding = sim->constraints.slip_rounding[i];
        const int due = lock->kind != GB_STOP && sim->events.pending[lock->slip] != 0.0 && !impacted;
        const int zero = fabs(slip) <= rounding || due || (gb_is_stuck(sim, i) && !impacted);
        int *state = &sim->constraints.decision[i];
        sim->mode[lock->slip] = lock->kind == GB_TIE ? sim->mode[lock->slip] : 0.0;
        if (!gb_does_rub(sim, i)) {
            *state = GB_FREE;
        } else if (lock->kind == GB_STOP) {
            const int rests =
                fabs(slip) <= rounding || (gb_is_stuck(sim, i) && !impacted) ||
                (sim->constraints.struck[i] && fabs(slip) <= 1e-9 * fabs(sim->constraints.slip_before[i]));
            *state = gb_touches(sim, i) && rests ? GB_CANDIDATE : GB_IS_OPEN;
        } else if (zero || gb_is_unlimited(sim, i)) {
            *state = GB_CANDIDATE;
        } else {
            *state = GB_SLIDES;
            sim->mode[lock->slip] = slip > 0.0 ? 1.0 : -1.0;
        }
    }
}

/* A lock that has just reached a limit of its force (not one that shares its load) does not hold any more. */
static void release_due(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_locks; i++) {
        const gb_lock *lock = &model->locks[i];
        if (sim->constraints.decision[i] != GB_CANDIDATE || sim->events.pending[lock->hold] == 0.0) {
            continue;
        }
        const double held = sim->constraints.other[i], *limit = sim->constraints.bounds + 5 * i;
        if (lock->kind == GB_LOSS) {
            sim->constraints.released[i] = 1; /* its options say how it goes on */
            continue;
        }
        if (sim->constraints.was_redundant[i]) {
            sim->constraints.shrink[i] = 1e-6;
            continue;
        }
        const int upper = held - limit[1] > limit[0] - held;
        sim->constraints.decision[i] = lock->kind == GB_STOP ? GB_IS_OPEN : GB_SLIDES;
        sim->mode[lock->slip] = lock->kind == GB_STOP ? 0.0 : upper ? -1.0 : 1.0;
        sim->constraints.released[i] = 1;
    }
}

/* The limits that belong to the new modes, and where switches sit on them. */
static void take_modes(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_locks; i++) {
        const gb_lock *lock = &model->locks[i];
        const double direction = sim->mode[lock->slip];
        sim->mode[lock->hold] = sim->constraints.decision[i] == GB_CANDIDATE;
        sim->events.armed[lock->hold] = 0.0;
        if (lock->kind == GB_TIE) {
            sim->events.armed[lock->slip] = sim->events.pending[lock->slip] != 0.0 ? -direction : 0.0;
        } else if (lock->kind == GB_STOP) {
            sim->events.armed[lock->slip] =
                sim->constraints.decision[i] == GB_IS_OPEN && gb_touches(sim, i) ? -1.0 : 0.0;
        } else {
            const int sits =
                sim->constraints.decision[i] == GB_SLIDES &&
                (sim->constraints.released[i] || fabs(sim->constraints.slip[i]) <= sim->constraints.slip_rounding[i] ||
                 sim->events.pending[lock->slip] != 0.0);
            sim->events.armed[lock->slip] = sits ? -direction : 0.0;
        }
        if (sim->events.armed[lock->slip] != 0.0) {
            sim->head->events.armed = 1;
        }
    }
}

/* A switch of lock i was due and nothing came of it: it counts as a flip, so that the same does not come back for ever
 * where quantities leave their limits no faster than rounding. */
static int count_vain(gb_sim *sim, int i) {
    const gb_lock *lock = &sim->model->locks[i];
    const int slip = sim->events.pending[lock->slip] != 0.0, hold = sim->events.pending[lock->hold] != 0.0;
    const int code = slip ? gb_count_flip(sim, lock->slip) : GB_DONE;
    return code == GB_DONE && hold ? gb_count_flip(sim, lock->hold) : code;
}

/* Events of the locks whose mode is another one than before. */
static int log_changes(gb_sim *sim, int log) {
    const gb_model *model = sim->model;
    int code = GB_DONE;
    for (int i = 0; i < model->n_locks; i++) {
        const gb_lock *lock = &model->locks[i];
        const double now = shown_mode(sim, i), before = sim->constraints.mode_before[i];
        if (now != before) {
            if (log && !(lock->kind == GB_STOP && sim->constraints.struck[i])) {
                gb_log(sim, lock->slip, 0, before, now);
            }
            if (log && code == GB_DONE) {
                code = gb_count_flip(sim, lock->hold);
            }
        } else if (log && code == GB_DONE && !sim->constraints.struck[i]) {
            code = count_vain(sim, i);
        }
        if (sim->constraints.struck[i]) {
            sim->events.flip_time[lock->slip] = sim->head->front.t1;
        }
        sim->events.pending[lock->slip] = sim->events.pending[lock->hold] = 0.0;
    }
    return code;
}

/* Held forces of the old modes, and who shared a load, before anything changes. */
static void look_back(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int n = model->n_locks;
    for (int i = 0; i < n; i++) {
        sim->constraints.mode_before[i] = shown_mode(sim, i);
        sim->constraints.was_redundant[i] =
            sim->mode[model->n_switches] > 0.0 && sim->mode[model->n_switches + gb_lock_shared(n) + i] != 0.0;
        sim->constraints.shrink[i] = 0.0;
        sim->constraints.released[i] = sim->constraints.struck[i] = 0;
    }
    model->holding(sim->par, sim->mode, sim->instant.time_terms, sim->constraints.y, sim->constraints.other,
                   sim->constraints.force);
}

/* A capacity that comes down to zero at a corner and stays there crosses nothing: its lock is free all the same. */
static void free_the_idle(gb_sim *sim) {
    for (int i = 0; i < sim->model->n_locks; i++) {
        const int free = sim->model->locks[i].free;
        if (free >= 0 && sim->mode[free] < 0.5 && !gb_does_rub(sim, i)) {
            gb_set_mode(sim, free, 1.0, 0);
        }
    }
}

/* A lock that flips again at once stands where forces and limits vanish together: what comes next is told by a look a
 * little ahead, further at every try. Puts the state there into `look`, and its time columns into tau_one. */
static int look_ahead(gb_sim *sim) {
    const gb_model *model = sim->model;
    const gb_head *head = sim->head;
    double flips = 0.0;
    for (int i = 0; i < model->n_locks; i++) {
        const gb_lock *lock = &model->locks[i];
        const int due = sim->events.pending[lock->hold] != 0.0 || sim->events.pending[lock->slip] != 0.0;
        const int stands =
            head->front.t1 - sim->events.flip_time[lock->hold] <= 10.0 * gb_rounding(head->front.t1, head->front.h);
        flips = due && stands ? gb_max(flips, sim->events.flips[lock->hold]) : flips;
    }
    sim->constraints.y = sim->y;
    if (flips == 0.0) {
        return GB_DONE;
    }
    const double ahead = ldexp(gb_rounding(head->front.t1, head->front.h), 2 * (int)flips);
    const int code = gb_columns_at(sim, head->front.t1 + ahead);
    if (code == GB_DONE) {
        model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->y, sim->z2);
        memcpy(sim->z, sim->y, sizeof(double) * (size_t)model->n_total);
        for (int i = 0; i < model->n; i++) {
            sim->z[i] += ahead * sim->z2[i];
        }
        sim->constraints.y = sim->z;
    }
    return code;
}

/* How long the first of the bodies that have just hit a stop stays away from it. */
static double shortest_flight(const gb_sim *sim) {
    double shortest = HUGE_VAL;
    for (int i = 0; i < sim->model->n_locks; i++) {
        double size;
        const double rate = gb_weighed_rate(sim, i, &size);
        if (gb_is_stop(sim, i) && sim->constraints.struck[i] && sim->constraints.decision[i] == GB_IS_OPEN &&
            rate < 0.0) {
            shortest = gb_min(shortest, -2.0 * sim->constraints.slip[i] / rate);
        }
    }
    return shortest;
}

/* A stop that a start value lies beyond, or a lossy tie whose sides start at speeds that it does not allow; or -1. 1e-9
 * of what is given counts as rounding. */
static int begins_beyond(const gb_sim *sim) {
    const gb_model *model = sim->model;
    double size = 0.0, speed = 0.0;
    for (int i = model->n - model->n_speeds; i < model->n; i++) {
        speed = gb_max(speed, fabs(sim->y[i]));
    }
    for (int i = 0; i < model->n - model->n_speeds; i++) {
        size = gb_max(size, fabs(sim->y[i]));
    }
    for (int i = 0; i < model->n_locks; i++) {
        if (gb_is_stop(sim, i) && sim->events.s[model->locks[i].slip] < -1e-9 * size - 1e-15) {
            return i;
        }
        if (model->locks[i].kind == GB_TIE &&
            fabs(sim->constraints.slip[i]) > 1e-9 * speed * sim->constraints.row_size[i]) {
            return i;
        }
    }
    return -1;
}

/* Event functions, time terms and slips at the front, and the state by which it is decided. */
static int look_at_front(gb_sim *sim, int log) {
    int code = gb_surfaces_now(sim);
    if (code == GB_DONE) {
        code = gb_columns_at(sim, sim->head->front.t1);
    }
    if (code == GB_DONE) {
        gb_slips_now(sim);
    }
    const int beyond = code == GB_DONE && !log ? begins_beyond(sim) : -1;
    if (beyond >= 0) {
        const int slip = sim->model->locks[beyond].slip;
        return gb_fail(sim, GB_ERR_BEYOND, slip, sim->head->front.t1, sim->events.s[slip]);
    }
    if (code == GB_DONE) {
        gb_project(sim, sim->instant.time_terms);
        code = look_ahead(sim);
    }
    return code;
}

/* Impacts, then forces: what each constraint does from here. */
static int decide(gb_sim *sim) {
    const gb_model *model = sim->model;
    look_back(sim);
    double *held = sim->constraints.force_before;
    memcpy(held, sim->constraints.other, sizeof(double) * (size_t)model->n_locks);
    for (int i = 0; i < model->n_locks; i++) {
        if (gb_is_stuck(sim, i) && model->locks[i].kind != GB_TIE && !gb_is_stop(sim, i)) {
            sim->mode[model->locks[i].slip] = 0.0;
        }
    }
    model->limits(sim->par, sim->mode, sim->instant.time_terms, sim->constraints.y, sim->constraints.bounds);
    free_the_idle(sim);
    gb_slips_now(sim);
    int code = gb_impact(sim);
    int impacted = 0;
    for (int i = 0; i < model->n_locks; i++) {
        impacted = impacted || sim->constraints.struck[i];
    }
    sort_by_slip(sim, impacted);
    model->limits(sim->par, sim->mode, sim->instant.time_terms, sim->constraints.y, sim->constraints.bounds);
    memcpy(sim->constraints.other, held, sizeof(double) * (size_t)model->n_locks);
    release_due(sim);
    if (code == GB_DONE) {
        code = gb_has_lossy(sim) ? gb_weigh_lossy(sim) : gb_weigh(sim);
    }
    return code;
}

int gb_settle_locks(gb_sim *sim, int log) {
    const gb_model *model = sim->model;
    if (model->n_locks == 0) {
        return GB_DONE;
    }
    int code = look_at_front(sim, log);
    if (code != GB_DONE) {
        return code;
    }
    code = decide(sim);
    if (sim->constraints.y != sim->y && code == GB_DONE) {
        code = gb_columns_at(sim, sim->head->front.t1);
    }
    sim->events.flight = shortest_flight(sim);
    take_modes(sim);
    gb_remember(sim, sim->mode, sim->instant.time_terms, sim->y);
    gb_project(sim, sim->instant.time_terms);
    gb_rehash(sim);
    if (model->n_switches > 0) {
        model->bounds(sim->par, sim->mode, sim->events.lo, sim->events.hi);
    }
    const int changes = log_changes(sim, log);
    return code == GB_DONE ? changes : code;
}
