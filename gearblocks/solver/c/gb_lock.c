/* What sticks: after every event the modes of all locks are decided together.
 *
 * Impacts first: stops that close and unlimited locks that close on a slip share one complementarity problem (Newton's
 * restitution; friction with a limit transmits no impulse). Then all that does not slip is a candidate to stick: the
 * forces that would keep every slip at zero, each within its limits, are another such problem; where a force is at a
 * limit and the slip accelerates, the lock slides that way. Both have one solution for the motion, whatever the order.
 */
#include "gb_lock.h"
#include "gb_internal.h"
#include "gb_locks.h"

int gb_is_stuck(const gb_sim *sim, int i) {
    return sim->mode[sim->model->locks[i].hold] > 0.5;
}

int gb_is_stop(const gb_sim *sim, int i) {
    return sim->model->locks[i].kind == GB_STOP;
}

/* Mode for the events: 0 stuck, 1 forward, -1 backward, 2 free; of a stop 1 closed, 0 open. */
static double shown_mode(const gb_sim *sim, int i) {
    const gb_lock *lock = &sim->model->locks[i];
    if (lock->kind == GB_STOP || lock->kind == GB_TIE) {
        return sim->mode[lock->hold];
    }
    return gb_is_stuck(sim, i) ? 0.0 : sim->mode[lock->slip] == 0.0 ? 2.0 : sim->mode[lock->slip];
}

int gb_is_unlimited(const gb_sim *sim, int i) {
    const double *limit = sim->limit + 5 * i;
    return sim->model->locks[i].kind != GB_LOSS && limit[0] <= -HUGE_VAL && limit[1] >= HUGE_VAL;
}

/* Sums of the sizes of the rows' numbers, by which the rounding of slips is judged. */
void gb_size_locks(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_locks; i++) {
        sim->lock_size[i] = 0.0;
        model->grip(sim->par, sim->mode, sim->tau_one, sim->y, i, 0, sim->grip);
        for (int k = 0; k < model->n_speeds; k++) {
            sim->lock_size[i] += fabs(sim->grip[k]);
        }
        sim->lock_size[i] = gb_max(sim->lock_size[i], 1.0);
    }
}

/* The memory behind the modes. */
void gb_remember(gb_sim *sim, double *mode, const double *tau, const double *y) {
    if (sim->model->n_locks > 0) {
        sim->model->remember(sim->par, mode, tau, y);
    }
}

/* A row's modes with their memory, in a place that the next call overwrites. */
const double *gb_full_modes(gb_sim *sim, const double *mode, const double *tau, const double *y) {
    const gb_model *model = sim->model;
    if (model->n_locks == 0) {
        return mode;
    }
    memcpy(sim->other_mode, mode, sizeof(double) * (size_t)model->n_switches);
    model->remember(sim->par, sim->other_mode, tau, y);
    return sim->other_mode;
}

/* Speeds at which nothing slips that sticks; 1: they changed by more than rounding. */
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

/* Slips at the front, and what is no more than rounding of each. */
void gb_slips_now(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int first = model->n - model->n_speeds;
    model->slips(sim->par, sim->mode, sim->tau_one, sim->y, NULL, sim->slip);
    double size = 0.0;
    for (int i = first; i < model->n; i++) {
        size = gb_max(size, fabs(sim->y[i]));
    }
    for (int i = 0; i < model->n_locks; i++) {
        sim->slip_rounding[i] = 64.0 * DBL_EPSILON * size * sim->lock_size[i];
    }
}

/* The gap of a stop is closed: it has just been met, or has no width. */
int gb_touches(const gb_sim *sim, int i) {
    const gb_lock *lock = &sim->model->locks[i];
    return gb_is_stuck(sim, i) || sim->due[lock->slip] != 0.0 || sim->on[lock->slip] == -1.0 ||
           sim->s[lock->slip] <= 0.0;
}

int gb_does_rub(const gb_sim *sim, int i) {
    const gb_lock *lock = &sim->model->locks[i];
    if (lock->kind != GB_FRICTION) {
        return 1;
    }
    if (lock->free < 0) {
        return sim->limit[5 * i + 4] > 0.0;
    }
    if (lock->free >= sim->model->n_surfaces) { /* time alone tells: at the instant of its switch the engagement is 0 */
        return sim->mode[lock->free] < 0.5;
    }
    return sim->mode[lock->free] < 0.5 && (sim->on[lock->free] != 0.0 || sim->limit[5 * i + 4] > 0.0);
}

/* What each lock could do, by its slip alone; what slides gets its direction. */
static void sort_by_slip(gb_sim *sim, int impacted) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_locks; i++) {
        const gb_lock *lock = &model->locks[i];
        const double slip = sim->slip[i], rounding = sim->slip_rounding[i];
        const int due = lock->kind != GB_STOP && sim->due[lock->slip] != 0.0 && !impacted;
        const int zero = fabs(slip) <= rounding || due || (gb_is_stuck(sim, i) && !impacted);
        int *state = &sim->lock_state[i];
        sim->mode[lock->slip] = lock->kind == GB_TIE ? sim->mode[lock->slip] : 0.0;
        if (!gb_does_rub(sim, i)) {
            *state = GB_FREE;
        } else if (lock->kind == GB_STOP) {
            const int rests = fabs(slip) <= rounding || (gb_is_stuck(sim, i) && !impacted) ||
                              (sim->struck[i] && fabs(slip) <= 1e-9 * fabs(sim->lock_before[i]));
            *state = gb_touches(sim, i) && rests ? GB_CANDIDATE : GB_IS_OPEN;
        } else if (zero || gb_is_unlimited(sim, i)) {
            *state = GB_CANDIDATE;
        } else {
            *state = GB_SLIDES;
            sim->mode[lock->slip] = slip > 0.0 ? 1.0 : -1.0;
        }
    }
}

/* Slip accelerations with the present modes and nothing held, into lock_bare. */
static int bare_accelerations(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_locks; i++) {
        sim->mode[model->locks[i].hold] = 0.0;
    }
    sim->mode[model->n_switches] = 0.0;
    model->rhs(sim->par, sim->mode, sim->tau_one, sim->look, sim->z2);
    sim->head->rhs_calls++;
    const int code = gb_check_finite(sim, GB_ERR_NAN_RATE, sim->z2, model->n, 0, sim->head->t1);
    if (code == GB_DONE) {
        model->slips(sim->par, sim->mode, sim->tau_one, sim->look, sim->z2, sim->lock_bare);
        sim->fastest = 0.0;
        for (int k = model->n - model->n_speeds; k < model->n; k++) {
            sim->fastest = gb_max(sim->fastest, fabs(sim->z2[k]));
        }
    }
    return code;
}

/* A lock that has just reached a limit of its force (not one that shares its load) does not hold any more. */
static void release_due(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_locks; i++) {
        const gb_lock *lock = &model->locks[i];
        if (sim->lock_state[i] != GB_CANDIDATE || sim->due[lock->hold] == 0.0) {
            continue;
        }
        const double held = sim->lock_other[i], *limit = sim->limit + 5 * i;
        if (lock->kind == GB_LOSS) {
            sim->released[i] = 1; /* its options say how it goes on */
            continue;
        }
        if (sim->was_shared[i]) {
            sim->shrink[i] = 1e-6;
            continue;
        }
        const int upper = held - limit[1] > limit[0] - held;
        sim->lock_state[i] = lock->kind == GB_STOP ? GB_IS_OPEN : GB_SLIDES;
        sim->mode[lock->slip] = lock->kind == GB_STOP ? 0.0 : upper ? -1.0 : 1.0;
        sim->released[i] = 1;
    }
}

/* What cannot be told from zero in a slip acceleration whose terms add up to `size`. */
double gb_rate_rounding(const gb_sim *sim, int i, double size) {
    return gb_max(1e-10 * size, 256.0 * DBL_EPSILON * sim->lock_size[i] * sim->fastest);
}

/* Locks that no force can break must not be asked for slips that contradict each other (two of them between a shaft of
 * prescribed speed and the ground): after the forces x, or impulses, nothing may be left of b where x is inside its
 * limits. */
int gb_refuse_tie_up(gb_sim *sim, int count) {
    const double *b = sim->lock_right, *x = sim->lock_force;
    double most = 0.0;
    for (int i = 0; i < count; i++) {
        most = gb_max(most, fabs(b[i]));
    }
    for (int i = 0; i < count; i++) {
        double left = b[i], size = fabs(b[i]);
        for (int j = 0; j < count; j++) {
            const double part = sim->lock_matrix[i * count + j] * x[j];
            left += part;
            size += fabs(part);
        }
        const int unlimited = sim->lock_lo[i] <= -HUGE_VAL && sim->lock_hi[i] >= HUGE_VAL;
        if (unlimited && fabs(left) > 1e-4 * most + 1e-12 * size) {
            const int lock = sim->lock_index[i];
            return gb_fail(sim, GB_ERR_BRANCH, sim->model->locks[lock].slip, sim->head->t1, left);
        }
    }
    return GB_DONE;
}

/* No force of lock i changes its slip, which grows all the same: time prescribes the motion of both sides. */
static int cannot_hold(const gb_sim *sim, int i) {
    const double own = sim->response[i * sim->model->n_locks + i];
    return sim->model->locks[i].kind == GB_FRICTION && !(own > 0.0) && sim->lock_bare[i] != 0.0;
}

/* The candidates against each other: forces within their limits that keep them from slipping. Those that slip all the
 * same slide from here; returns how many. */
static int decide(gb_sim *sim, int *code) {
    const gb_model *model = sim->model;
    const int n = model->n_locks;
    int *index = sim->lock_index, count = 0, lost = 0;
    double *lo = sim->lock_lo, *hi = sim->lock_hi, *b = sim->lock_right, *x = sim->lock_force;
    for (int i = 0; i < n; i++) {
        if (sim->lock_state[i] == GB_CANDIDATE && cannot_hold(sim, i)) {
            sim->lock_state[i] = GB_SLIDES;
            sim->mode[model->locks[i].slip] = sim->lock_bare[i] > 0.0 ? 1.0 : -1.0;
            lost++;
        }
        if (sim->lock_state[i] == GB_CANDIDATE) {
            const double *limit = sim->limit + 5 * i, keep = 1.0 - sim->shrink[i];
            const int bounded = model->locks[i].kind != GB_LOSS;
            lo[count] = bounded && limit[0] > -HUGE_VAL ? keep * limit[0] : -HUGE_VAL;
            hi[count] = bounded && limit[1] < HUGE_VAL ? gb_max(keep * limit[1], lo[count]) : HUGE_VAL;
            b[count] = sim->lock_bare[i];
            index[count++] = i;
        }
    }
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < count; j++) {
            sim->lock_matrix[i * count + j] = sim->response[index[i] * n + index[j]];
        }
    }
    if (!gb_lock_box(count, sim->lock_matrix, b, lo, hi, x)) {
        *code = gb_fail(sim, GB_ERR_BRANCH, model->locks[index[0]].slip, sim->head->t1, b[0]);
        return 0;
    }
    for (int i = 0; i < count; i++) {
        const gb_lock *lock = &model->locks[index[i]];
        double w = b[i], size = fabs(b[i]);
        for (int j = 0; j < count; j++) {
            w += sim->lock_matrix[i * count + j] * x[j];
            size += fabs(sim->lock_matrix[i * count + j] * x[j]);
        }
        if (fabs(w) > gb_rate_rounding(sim, index[i], size) && (x[i] <= lo[i] || x[i] >= hi[i])) {
            sim->lock_state[index[i]] = lock->kind == GB_STOP ? GB_IS_OPEN : GB_SLIDES;
            sim->mode[lock->slip] = lock->kind == GB_STOP ? 0.0 : w > 0.0 ? 1.0 : -1.0;
            sim->shrink[index[i]] = 0.0;
            lost++;
        }
    }
    if (lost == 0) {
        *code = gb_refuse_tie_up(sim, count);
    }
    sim->lock_count = count;
    return lost;
}

/* Candidates that cannot be held slide, until all others can. */
int gb_weigh(gb_sim *sim) {
    int code = GB_DONE;
    for (int round = 0; code == GB_DONE && round <= sim->model->n_locks; round++) {
        code = bare_accelerations(sim);
        if (code == GB_DONE) {
            sim->model->pulls(sim->par, sim->mode, sim->tau_one, sim->look, 1, sim->response);
            if (decide(sim, &code) == 0) {
                break;
            }
        }
    }
    return code;
}

/* The force on lock i after `weigh`, and its slip acceleration with all of them. */
double gb_weighed_force(const gb_sim *sim, int i) {
    for (int j = 0; j < sim->lock_count; j++) {
        if (sim->lock_index[j] == i) {
            return sim->lock_force[j];
        }
    }
    return 0.0;
}

double gb_weighed_rate(const gb_sim *sim, int i, double *size) {
    double rate = sim->lock_bare[i];
    *size = fabs(rate);
    for (int j = 0; j < sim->lock_count; j++) {
        const double part = sim->response[i * sim->model->n_locks + sim->lock_index[j]] * sim->lock_force[j];
        rate += part;
        *size += fabs(part);
    }
    return rate;
}

/* The limits that belong to the new modes, and where switches sit on them. */
static void take_modes(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_locks; i++) {
        const gb_lock *lock = &model->locks[i];
        const double direction = sim->mode[lock->slip];
        sim->mode[lock->hold] = sim->lock_state[i] == GB_CANDIDATE;
        sim->on[lock->hold] = 0.0;
        if (lock->kind == GB_TIE) {
            sim->on[lock->slip] = sim->due[lock->slip] != 0.0 ? -direction : 0.0;
        } else if (lock->kind == GB_STOP) {
            sim->on[lock->slip] = sim->lock_state[i] == GB_IS_OPEN && gb_touches(sim, i) ? -1.0 : 0.0;
        } else {
            const int sits =
                sim->lock_state[i] == GB_SLIDES &&
                (sim->released[i] || fabs(sim->slip[i]) <= sim->slip_rounding[i] || sim->due[lock->slip] != 0.0);
            sim->on[lock->slip] = sits ? -direction : 0.0;
        }
        if (sim->on[lock->slip] != 0.0) {
            sim->head->sitting = 1;
        }
    }
}

/* A switch of lock i was due and nothing came of it: it counts as a flip, so that the same does not come back for ever
 * where quantities leave their limits no faster than rounding. */
static int count_vain(gb_sim *sim, int i) {
    const gb_lock *lock = &sim->model->locks[i];
    const int slip = sim->due[lock->slip] != 0.0, hold = sim->due[lock->hold] != 0.0;
    const int code = slip ? gb_count_flip(sim, lock->slip) : GB_DONE;
    return code == GB_DONE && hold ? gb_count_flip(sim, lock->hold) : code;
}

/* Events of the locks whose mode is another one than before. */
static int log_changes(gb_sim *sim, int log) {
    const gb_model *model = sim->model;
    int code = GB_DONE;
    for (int i = 0; i < model->n_locks; i++) {
        const gb_lock *lock = &model->locks[i];
        const double now = shown_mode(sim, i), before = sim->lock_mode[i];
        if (now != before) {
            if (log && !(lock->kind == GB_STOP && sim->struck[i])) {
                gb_log(sim, lock->slip, 0, before, now);
            }
            if (log && code == GB_DONE) {
                code = gb_count_flip(sim, lock->hold);
            }
        } else if (log && code == GB_DONE && !sim->struck[i]) {
            code = count_vain(sim, i);
        }
        if (sim->struck[i]) {
            sim->flip_time[lock->slip] = sim->head->t1;
        }
        sim->due[lock->slip] = sim->due[lock->hold] = 0.0;
    }
    return code;
}

/* Held forces of the old modes, and who shared a load, before anything changes. */
static void look_back(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int n = model->n_locks;
    for (int i = 0; i < n; i++) {
        sim->lock_mode[i] = shown_mode(sim, i);
        sim->was_shared[i] =
            sim->mode[model->n_switches] > 0.0 && sim->mode[model->n_switches + gb_lock_shared(n) + i] != 0.0;
        sim->shrink[i] = 0.0;
        sim->released[i] = sim->struck[i] = 0;
    }
    model->holding(sim->par, sim->mode, sim->tau_one, sim->look, sim->lock_other, sim->lock_force);
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
        const int due = sim->due[lock->hold] != 0.0 || sim->due[lock->slip] != 0.0;
        const int stands = head->t1 - sim->flip_time[lock->hold] <= 10.0 * gb_rounding(head->t1, head->h);
        flips = due && stands ? gb_max(flips, sim->flips[lock->hold]) : flips;
    }
    sim->look = sim->y;
    if (flips == 0.0) {
        return GB_DONE;
    }
    const double ahead = ldexp(gb_rounding(head->t1, head->h), 2 * (int)flips);
    const int code = gb_columns_at(sim, head->t1 + ahead);
    if (code == GB_DONE) {
        model->rhs(sim->par, sim->mode, sim->tau_one, sim->y, sim->z2);
        memcpy(sim->z, sim->y, sizeof(double) * (size_t)model->n_total);
        for (int i = 0; i < model->n; i++) {
            sim->z[i] += ahead * sim->z2[i];
        }
        sim->look = sim->z;
    }
    return code;
}

/* How long the first of the bodies that have just hit a stop stays away from it. */
static double shortest_flight(const gb_sim *sim) {
    double shortest = HUGE_VAL;
    for (int i = 0; i < sim->model->n_locks; i++) {
        double size;
        const double rate = gb_weighed_rate(sim, i, &size);
        if (gb_is_stop(sim, i) && sim->struck[i] && sim->lock_state[i] == GB_IS_OPEN && rate < 0.0) {
            shortest = gb_min(shortest, -2.0 * sim->slip[i] / rate);
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
        if (gb_is_stop(sim, i) && sim->s[model->locks[i].slip] < -1e-9 * size - 1e-15) {
            return i;
        }
        if (model->locks[i].kind == GB_TIE && fabs(sim->slip[i]) > 1e-9 * speed * sim->lock_size[i]) {
            return i;
        }
    }
    return -1;
}

/* Decides about all locks at the front. */
int gb_settle_locks(gb_sim *sim, int log) {
    const gb_model *model = sim->model;
    if (model->n_locks == 0) {
        return GB_DONE;
    }
    int code = gb_surfaces_now(sim);
    if (code == GB_DONE) {
        code = gb_columns_at(sim, sim->head->t1);
    }
    if (code == GB_DONE) {
        gb_slips_now(sim);
    }
    const int beyond = code == GB_DONE && !log ? begins_beyond(sim) : -1;
    if (beyond >= 0) {
        const int slip = model->locks[beyond].slip;
        return gb_fail(sim, GB_ERR_BEYOND, slip, sim->head->t1, sim->s[slip]);
    }
    if (code == GB_DONE) {
        gb_project(sim, sim->tau_one);
        code = look_ahead(sim);
    }
    if (code != GB_DONE) {
        return code;
    }
    look_back(sim);
    double *held = sim->lock_old;
    memcpy(held, sim->lock_other, sizeof(double) * (size_t)model->n_locks);
    for (int i = 0; i < model->n_locks; i++) {
        if (gb_is_stuck(sim, i) && model->locks[i].kind != GB_TIE && !gb_is_stop(sim, i)) {
            sim->mode[model->locks[i].slip] = 0.0;
        }
    }
    model->limits(sim->par, sim->mode, sim->tau_one, sim->look, sim->limit);
    free_the_idle(sim);
    gb_slips_now(sim);
    code = gb_impact(sim);
    int impacted = 0;
    for (int i = 0; i < model->n_locks; i++) {
        impacted = impacted || sim->struck[i];
    }
    sort_by_slip(sim, impacted);
    model->limits(sim->par, sim->mode, sim->tau_one, sim->look, sim->limit);
    memcpy(sim->lock_other, held, sizeof(double) * (size_t)model->n_locks);
    release_due(sim);
    if (code == GB_DONE) {
        code = gb_has_lossy(sim) ? gb_weigh_lossy(sim) : gb_weigh(sim);
    }
    if (sim->look != sim->y && code == GB_DONE) {
        code = gb_columns_at(sim, sim->head->t1);
    }
    sim->flight = shortest_flight(sim);
    take_modes(sim);
    gb_remember(sim, sim->mode, sim->tau_one, sim->y);
    gb_project(sim, sim->tau_one);
    gb_rehash(sim);
    if (model->n_switches > 0) {
        model->bounds(sim->par, sim->mode, sim->lo, sim->hi);
    }
    const int changes = log_changes(sim, log);
    return code == GB_DONE ? changes : code;
}
