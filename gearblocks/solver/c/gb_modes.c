#include "gb_modes.h"
#include "gb_rates.h"
#include "gb_report.h"
#include "gb_stage_modes.h"
#include "gb_vector.h"

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

void gb_set_mode(gb_sim *sim, int i, double mode, int log) {
    if (log) {
        gb_log(sim, i, i >= sim->model->n_event_functions, sim->mode[i], mode);
    }
    sim->head->events.mode_hash ^= mode_hash(i, sim->mode[i]) ^ mode_hash(i, mode);
    sim->mode[i] = mode;
}

static void watch_not(gb_sim *sim, int i) {
    sim->events.lo[i] = -HUGE_VAL;
    sim->events.hi[i] = HUGE_VAL;
}

void gb_mode_limits(gb_sim *sim) {
    sim->model->mode_limits(sim->par, sim->mode, sim->events.lo, sim->events.hi);
    for (int j = 0; j < sim->head->events.n_sliding; j++) {
        watch_not(sim, sim->head->events.sliding[j]);
    }
    for (int c = 0; c < sim->model->n_constraints && sim->head->events.n_sliding > 0; c++) {
        const gb_constraint *of = &sim->model->constraints[c];
        if (gb_rests(sim, c) || gb_holds_by_mean(sim, c)) {
            watch_not(sim, of->active);
            watch_not(sim, of->kind == GB_LOSS ? sim->model->constraints[of->partner].slip : of->active);
        }
    }
    for (int i = 0; i < sim->model->n_event_functions && sim->head->events.held_until < HUGE_VAL; i++) {
        if (sim->events.held_side[i] != 0.0) {
            *(sim->events.held_side[i] < 0.0 ? sim->events.lo + i : sim->events.hi + i) =
                copysign(HUGE_VAL, sim->events.held_side[i]);
        }
    }
}

void gb_hold_limit(gb_sim *sim, int i, double side, double time) {
    sim->events.held_side[i] = side;
    sim->events.held[i] = time;
    sim->head->events.held_until = gb_min(sim->head->events.held_until, time);
}

/* It stands on a limit of its mode but for rounding: the mode is that of the side to which it goes. */
static int stands_on_limit(const gb_sim *sim, int i, double s) {
    const double lo = sim->events.lo[i], hi = sim->events.hi[i], unit = 64.0 * DBL_EPSILON;
    return fabs(s - lo) <= unit * fabs(lo) || fabs(s - hi) <= unit * fabs(hi);
}

void gb_modes_at_slips(gb_sim *sim, int log) {
    const gb_model *model = sim->model;
    double *s = sim->events.moved;
    if (model->n_slip_switches > 0) {
        gb_mode_limits(sim);
        model->event_functions(sim->par, sim->mode, sim->instant.time_terms, sim->constraints.y, s);
    }
    for (int k = 0; k < model->n_slip_switches; k++) {
        const int i = model->slip_switches[k];
        const double mode = model->mode_at(sim->par, i, s[i]);
        if (mode != sim->mode[i] && !stands_on_limit(sim, i, s[i])) {
            gb_set_mode(sim, i, mode, log && sim->events.role[i] == GB_ORDINARY);
            sim->events.armed[i] = 0.0;
        }
    }
}

void gb_rehash(gb_sim *sim) {
    sim->head->events.mode_hash = 0;
    for (int i = 0; i < sim->model->n_switches; i++) {
        sim->head->events.mode_hash ^= mode_hash(i, sim->mode[i]) ^ mode_hash(i, 0.0);
    }
}

int gb_flips_at_front(const gb_sim *sim, int i) {
    const double t = sim->head->front.t1;
    return t - sim->events.flip_time[i] <= 10.0 * gb_rounding(t, sim->head->front.h);
}

int gb_count_flip(gb_sim *sim, int i) {
    const gb_head *head = sim->head;
    sim->events.flips[i] = gb_flips_at_front(sim, i) ? sim->events.flips[i] + 1.0 : 1.0;
    sim->events.flip_time[i] = head->front.t1;
    return sim->events.flips[i] > GB_FLIPS ? gb_fail(sim, GB_ERR_CHATTER, i, head->front.t1, sim->events.flips[i])
                                           : GB_DONE;
}

int gb_flipped_just_now(const gb_sim *sim) {
    const double t = sim->head->front.t1, since = t - 1e-6 * sim->head->control.h_largest;
    int last = -1;
    for (int i = 0; i < sim->model->n_event_functions; i++) {
        if (sim->events.role[i] != GB_CONSTRAINED && sim->events.flip_time[i] >= since &&
            t > sim->head->front.t_start && (last < 0 || sim->events.flip_time[i] > sim->events.flip_time[last])) {
            last = i;
        }
    }
    return last;
}

int gb_modes(const gb_sim *sim, double *mode) {
    memcpy(mode, sim->mode, sizeof(double) * (size_t)sim->model->n_switches);
    return sim->head->started ? GB_DONE : GB_ERR_STATE;
}

double gb_far_side(const gb_sim *sim, int i, double side) {
    const double limit = side < 0.0 ? sim->events.lo[i] : sim->events.hi[i], beside = copysign(DBL_MIN, side);
    return sim->model->mode_at(sim->par, i, limit == 0.0 ? beside : nextafter(limit, copysign(HUGE_VAL, side)));
}

void gb_refresh_breaks(gb_sim *sim, int all) {
    const gb_model *model = sim->model;
    double first = HUGE_VAL;
    for (int i = model->n_event_functions; i < model->n_switches; i++) {
        if (all || sim->events.next_time[i] <= sim->head->front.t1) {
            sim->events.next_time[i] =
                model->next_time(sim->par, i, sim->mode[i], sim->head->front.t1, &sim->events.next_mode[i]);
        }
        first = gb_min(first, sim->events.next_time[i]);
    }
    for (int j = 0; j < sim->inputs.n_moving; j++) {
        first = gb_min(first, sim->inputs.cell_end[sim->inputs.moving[j]]);
    }
    sim->head->events.t_break = first;
}

void gb_time_modes(gb_sim *sim, int log) {
    const gb_model *model = sim->model;
    const double t = sim->head->front.t1, after = t + 4.0 * DBL_EPSILON * fabs(t) + 1e-290;
    for (int i = model->n_event_functions; i < model->n_switches; i++) {
        const double mode = model->mode_at(sim->par, i, model->time_function(sim->par, i, after));
        if (mode != sim->mode[i]) {
            gb_set_mode(sim, i, mode, log && sim->events.role[i] == GB_ORDINARY);
        }
    }
    gb_refresh_breaks(sim, 1);
}

void gb_mark_time_events(gb_sim *sim) {
    for (int i = sim->model->n_event_functions; i < sim->model->n_switches; i++) {
        sim->events.pending[i] = sim->events.next_time[i] <= sim->head->front.t1 ? 2.0 : 0.0;
    }
    sim->head->events.pending = 1;
}

int gb_mark_modes(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int alone = model->n_constraints == 0 && !model->update_states && !model->balance_massless;
    const int lane = sim->method->stages, none = gb_stage_modes(sim, &sim->lanes, sim->unlocated.lanes, lane, sim->y);
    if (none >= 0) {
        return gb_fail(sim, GB_ERR_BRANCH, none, sim->head->front.t1, sim->events.s[none]);
    }
    for (int i = 0; i < model->n_event_functions; i++) {
        const int role = sim->events.role[i];
        const double s = sim->events.s[i], fit = model->mode_at(sim->par, i, s);
        if (role == GB_CONSTRAINED ? s < sim->events.lo[i] || s > sim->events.hi[i] : fit != sim->mode[i]) {
            sim->events.next_mode[i] = fit;
            sim->events.pending[i] = 3.0;
            sim->head->events.pending = !alone;
        }
    }
    for (int i = 0; i < model->n_event_functions && alone; i++) {
        if (sim->events.pending[i] == 3.0) { /* the rates at the front are those of its new mode already */
            sim->events.pending[i] = 0.0;
            gb_set_mode(sim, i, sim->events.next_mode[i], sim->events.role[i] == GB_ORDINARY);
        }
    }
    return GB_DONE;
}
