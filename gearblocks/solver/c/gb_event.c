/* What happens at an event: modes change, and only here. */
#include "gb_internal.h"

static uint64_t mix(uint64_t x) {
    x ^= x >> 31;
    x *= 0x9e3779b97f4a7c15u;
    x ^= x >> 29;
    x *= 0xbf58476d1ce4e5b9u;
    return x ^ (x >> 32);
}

static uint64_t mode_hash(int i, double mode) {
    uint64_t bits;
    memcpy(&bits, &mode, sizeof bits);
    return mix(bits + 0x9e3779b97f4a7c15u * (uint64_t)(i + 1));
}

void gb_log(gb_sim *sim, int index, int kind, double before, double after) {
    sim->head->events++;
    if (sim->n_log < sim->log_capacity) {
        const gb_event event = {sim->head->t1, before, after, index, kind};
        sim->log[sim->n_log++] = event;
    }
}

void gb_set_mode(gb_sim *sim, int i, double mode, int log) {
    if (log) {
        gb_log(sim, i, i >= sim->model->n_surfaces, sim->mode[i], mode);
    }
    sim->head->modes ^= mode_hash(i, sim->mode[i]) ^ mode_hash(i, mode);
    sim->mode[i] = mode;
}

/* The hash of all modes anew. */
void gb_rehash(gb_sim *sim) {
    sim->head->modes = 0;
    for (int i = 0; i < sim->model->n_switches; i++) {
        sim->head->modes ^= mode_hash(i, sim->mode[i]) ^ mode_hash(i, 0.0);
    }
}

/* A switch may flip again at once a few times, not for ever. */
int gb_count_flip(gb_sim *sim, int i) {
    const gb_head *head = sim->head;
    const int stands = head->t1 - sim->flip_time[i] <= 10.0 * gb_rounding(head->t1, head->h);
    sim->flips[i] = stands ? sim->flips[i] + 1.0 : 1.0;
    sim->flip_time[i] = head->t1;
    return sim->flips[i] > GB_FLIPS ? gb_fail(sim, GB_ERR_CHATTER, i, head->t1, sim->flips[i]) : GB_DONE;
}

/* The surfaces at the front, into s. */
int gb_surfaces_now(gb_sim *sim) {
    if (sim->model->n_surfaces > sim->model->n_affine) {
        const int code = gb_columns_at(sim, sim->head->t1);
        if (code != GB_DONE) {
            return code;
        }
    }
    sim->model->surfaces(sim->par, sim->mode, sim->tau_one, sim->y, sim->s);
    return GB_DONE;
}

/* -1 or 1: surface i is beyond its lower or upper limit by more than rounding. */
static int beyond(const gb_sim *sim, int i) {
    const double s = sim->s[i], lo = sim->lo[i], hi = sim->hi[i];
    const double unit = 64.0 * DBL_EPSILON;
    if (sim->on[i] != -1.0 && lo > -HUGE_VAL && s < lo - unit * (fabs(s) + fabs(lo))) {
        return -1;
    }
    return sim->on[i] != 1.0 && hi < HUGE_VAL && s > hi + unit * (fabs(s) + fabs(hi));
}

/* Makes the limits follow the modes and flips what is inconsistent, until nothing is. */
int gb_settle(gb_sim *sim, int log) {
    const gb_model *model = sim->model;
    int last = -1, code = GB_DONE;
    if (model->n_switches > 0) {
        model->bounds(sim->par, sim->mode, sim->lo, sim->hi);
    }
    for (int round = 0; round < GB_FLIPS && model->n_surfaces > 0; round++) {
        int changed = 0;
        code = gb_surfaces_now(sim);
        for (int i = 0; i < model->n_surfaces && code == GB_DONE; i++) {
            if (sim->role[i] != GB_LOCKED && beyond(sim, i)) {
                const double mode = model->mode_at(sim->par, i, sim->s[i]);
                if (mode == sim->mode[i]) {
                    return gb_fail(sim, GB_ERR_BRANCH, i, sim->head->t1, sim->s[i]);
                }
                gb_set_mode(sim, i, mode, log && sim->role[i] == GB_ORDINARY);
                sim->on[i] = 0.0;
                last = i;
                changed = 1;
                code = gb_count_flip(sim, i);
            }
        }
        if (!changed || code != GB_DONE) {
            return code;
        }
        model->bounds(sim->par, sim->mode, sim->lo, sim->hi);
    }
    return last < 0 ? code : gb_fail(sim, GB_ERR_BRANCH, last, sim->head->t1, sim->s[last]);
}

/* What sticks, and what else flips because of it. */
static int settle_with_locks(gb_sim *sim, int log) {
    int code = GB_DONE;
    uint64_t modes = ~sim->head->modes;
    for (int round = 0; round < GB_FLIPS && sim->model->n_locks > 0 && code == GB_DONE; round++) {
        code = gb_settle_locks(sim, log);
        modes = sim->head->modes;
        if (code == GB_DONE && (!log || sim->head->options.locate)) {
            code = gb_settle(sim, log);
        }
        if (modes == sim->head->modes) {
            break;
        }
    }
    return code;
}

/* Shafts without inertia into balance, and the modes that belong to it. */
static int balance(gb_sim *sim, int starting) {
    int code = sim->model->settle ? gb_columns_at(sim, sim->head->t1) : GB_DONE;
    uint64_t modes = ~sim->head->modes;
    for (int round = 0; round < GB_FLIPS && sim->model->settle && code == GB_DONE && modes != sim->head->modes;
         round++) {
        modes = sim->head->modes;
        sim->model->settle(sim->par, sim->mode, sim->tau_one, sim->y, starting);
        code = gb_settle(sim, !starting);
    }
    return code;
}

/* The next instant that time switches and tables announce. With `all`, or else only where the last one has come. */
void gb_refresh_breaks(gb_sim *sim, int all) {
    const gb_model *model = sim->model;
    double first = HUGE_VAL;
    for (int i = model->n_surfaces; i < model->n_switches; i++) {
        if (all || sim->next_time[i] <= sim->head->t1) {
            sim->next_time[i] = model->next_time(sim->par, i, sim->mode[i], sim->head->t1, &sim->next_mode[i]);
        }
        first = gb_min(first, sim->next_time[i]);
    }
    for (int j = 0; j < sim->n_moving; j++) {
        first = gb_min(first, sim->cell_end[sim->moving[j]]);
    }
    sim->head->t_break = first;
}

/* The front has reached an announced instant. */
void gb_mark_time_events(gb_sim *sim) {
    for (int i = sim->model->n_surfaces; i < sim->model->n_switches; i++) {
        sim->due[i] = sim->next_time[i] <= sim->head->t1 ? 2.0 : 0.0;
    }
    sim->head->pending = 1;
}

/* Without location: modes follow their surfaces at the end of the step. */
void gb_mark_modes(gb_sim *sim) {
    const gb_model *model = sim->model;
    if (model->n_surfaces == 0) {
        return;
    }
    model->surfaces(sim->par, sim->mode, sim->tau + sim->method->stages, sim->y, sim->s);
    for (int i = 0; i < model->n_surfaces; i++) {
        if (sim->role[i] == GB_LOCKED) {
            sim->due[i] = sim->s[i] < sim->lo[i] || sim->s[i] > sim->hi[i] ? 3.0 : 0.0;
            sim->head->pending = sim->head->pending || sim->due[i] != 0.0;
            continue;
        }
        const double mode = model->mode_at(sim->par, i, sim->s[i]);
        if (mode != sim->mode[i]) {
            sim->due[i] = 3.0;
            sim->next_mode[i] = mode;
            sim->head->pending = 1;
        }
    }
}

/* Mode of switch i on the far side of the limit that it leaves through. */
static double far_side(const gb_sim *sim, int i, double side) {
    return sim->model->mode_at(sim->par, i, side < 0.0 ? nextafter(sim->lo[i], -HUGE_VAL) : sim->hi[i]);
}

static int flip_due(gb_sim *sim) {
    int code = GB_DONE;
    for (int i = 0; i < sim->model->n_switches && code == GB_DONE; i++) {
        const double due = sim->due[i];
        if (due == 0.0 || sim->role[i] == GB_LOCKED) {
            continue;
        }
        sim->due[i] = 0.0;
        if (fabs(due) == 1.0) {
            gb_set_mode(sim, i, far_side(sim, i, due), sim->role[i] == GB_ORDINARY);
            sim->on[i] = -due;
            sim->head->sitting = 1;
            code = gb_count_flip(sim, i);
        } else {
            gb_set_mode(sim, i, sim->next_mode[i], sim->role[i] == GB_ORDINARY);
        }
    }
    return code;
}

/* The step size that worked last in these modes, where there is one. */
static void recall_step(gb_sim *sim) {
    gb_head *head = sim->head;
    const size_t slot = (size_t)(head->modes % GB_MEMORY);
    if (head->remembered_step[slot] > 0.0 && head->remembered_modes[slot] == head->modes) {
        head->h_next = head->remembered_step[slot];
    }
}

/* States that take a value as the modes change. */
static int hold_states(gb_sim *sim) {
    const int code = gb_columns_at(sim, sim->head->t1);
    if (code == GB_DONE) {
        sim->model->hold(sim->par, sim->before, sim->mode, sim->tau_one, sim->y);
    }
    return code;
}

/* Carries out what is due at the front. */
int gb_apply_event(gb_sim *sim) {
    gb_head *head = sim->head;
    if (sim->model->hold != NULL) {
        memcpy(sim->before, sim->mode, sizeof(double) * (size_t)sim->model->n_switches);
    }
    const uint64_t modes = head->modes;
    const size_t slot = (size_t)(modes % GB_MEMORY);
    head->remembered_modes[slot] = modes;
    head->remembered_step[slot] = head->h_worked;
    head->pending = 0;
    head->have_k1 = 0;
    head->row_due = 1;
    head->log_error = 0.0;
    const int timed = head->t1 >= head->t_break;
    if (timed) {
        gb_input_find(sim, head->t1, 1);
    }
    int code = flip_due(sim);
    if (code == GB_DONE && head->options.locate) {
        code = gb_settle(sim, 1);
    } else if (code == GB_DONE && sim->model->n_switches > 0) {
        sim->model->bounds(sim->par, sim->mode, sim->lo, sim->hi);
    }
    if (code == GB_DONE) {
        code = settle_with_locks(sim, 1);
    }
    if (code == GB_DONE) {
        code = balance(sim, 0);
    }
    if (timed) {
        gb_refresh_breaks(sim, 0);
    }
    if (code == GB_DONE && sim->model->hold != NULL) {
        code = hold_states(sim);
    }
    if (head->modes != modes) {
        recall_step(sim);
    }
    if (sim->model->n_locks > 0) { /* a step much longer than a bounce could not tell the bounce */
        head->h_next = gb_min(head->h_next, 2.0 * sim->flight);
    }
    return code;
}

/* On a limit exactly: the mode follows the direction of motion (right limit). Affine surfaces; the others are told by
 * the first step. */
static int start_on_limits(gb_sim *sim) {
    const gb_model *model = sim->model;
    int code = gb_columns_at(sim, sim->head->t1);
    if (code == GB_DONE) {
        code = gb_first_derivative(sim, sim->tau_one);
    }
    sim->head->have_k1 = 0;
    if (code != GB_DONE) {
        return code;
    }
    model->directions(sim->par, sim->k1, sim->slopes);
    for (int i = 0; i < model->n_affine; i++) {
        if (sim->role[i] == GB_LOCKED) {
            continue;
        }
        const double rounding = 64.0 * DBL_EPSILON * fabs(sim->s[i]) + DBL_MIN;
        const double side = fabs(sim->s[i] - sim->lo[i]) <= rounding ? -1.0 : fabs(sim->s[i] - sim->hi[i]) <= rounding;
        if (side != 0.0 && side * sim->slopes[i] > 0.0) {
            gb_set_mode(sim, i, far_side(sim, i, side), 0);
            sim->on[i] = -side;
            sim->head->sitting = 1;
        }
    }
    code = gb_settle(sim, 0);
    return code == GB_DONE ? settle_with_locks(sim, 0) : code;
}

/* Modes of the time switches just after the front, and what they announce. */
void gb_time_modes(gb_sim *sim, int log) {
    const gb_model *model = sim->model;
    const double t = sim->head->t1, after = t + 4.0 * DBL_EPSILON * fabs(t) + 1e-290;
    for (int i = model->n_surfaces; i < model->n_switches; i++) {
        const double mode = model->mode_at(sim->par, i, model->clock(sim->par, i, after));
        if (mode != sim->mode[i]) {
            gb_set_mode(sim, i, mode, log && sim->role[i] == GB_ORDINARY);
        }
    }
    gb_refresh_breaks(sim, 1);
}

/* Modes of the state's switches until they agree with each other. */
static int modes_of_state(gb_sim *sim) {
    const gb_model *model = sim->model;
    int code = GB_DONE, changed = model->n_surfaces > 0, last = 0;
    for (int round = 0; round < GB_FLIPS && changed; round++) {
        changed = 0;
        code = gb_surfaces_now(sim);
        for (int i = 0; i < model->n_surfaces && code == GB_DONE; i++) {
            const double mode = model->mode_at(sim->par, i, sim->s[i]);
            if (sim->role[i] != GB_LOCKED && mode != sim->mode[i]) {
                gb_set_mode(sim, i, mode, 0);
                changed = 1;
                last = i;
            }
        }
    }
    return code == GB_DONE && changed ? gb_fail(sim, GB_ERR_BRANCH, last, sim->head->t1, sim->s[last]) : code;
}

/* Start values are worked out with modes (a ratio law on its segment), and modes with start values: until both stay. */
static int start_with_modes(gb_sim *sim) {
    const gb_model *model = sim->model;
    const size_t size = sizeof(double) * (size_t)model->n_total;
    int code = modes_of_state(sim);
    for (int round = 0; round < GB_FLIPS && code == GB_DONE; round++) {
        memcpy(sim->z, sim->y, size);
        code = gb_columns_at(sim, sim->head->t1);
        model->start(sim->par, sim->mode, sim->tau_one, sim->y);
        gb_turns_wrap(sim, 0);
        if (code != GB_DONE || memcmp(sim->z, sim->y, size) == 0) {
            break;
        }
        gb_weights_grow(sim, sim->y);
        code = modes_of_state(sim);
    }
    return code;
}

/* Modes at the start: those of time just after it, then those of the state. fresh: its values are those of
 * model->start. */
int gb_modes_start(gb_sim *sim, int fresh) {
    const gb_model *model = sim->model;
    gb_time_modes(sim, 0);
    int code = fresh && model->n_surfaces > 0 ? start_with_modes(sim) : modes_of_state(sim);
    if (code != GB_DONE) {
        return code;
    }
    code = gb_settle(sim, 0);
    if (code == GB_DONE) {
        code = settle_with_locks(sim, 0);
    }
    if (code == GB_DONE) {
        code = balance(sim, 1);
    }
    return code == GB_DONE && model->n_affine > 0 ? start_on_limits(sim) : code;
}
