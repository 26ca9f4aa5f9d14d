#include "gb_departure.h"
#include "gb_constraint_state.h"
#include "gb_evaluate.h"
#include "gb_event.h"
#include "gb_follow.h"
#include "gb_force_noise.h"
#include "gb_limit_rest.h"
#include "gb_modes.h"
#include "gb_report.h"
#include "gb_sliding.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

/* How far ahead is looked, and how much further each time; steps of a look, and the most where they do not agree. */
static const double SHORTEST = 1e-7, LONGEST = 1.0, FURTHER = 4.0;
enum { STEPS = 16, MOST_STEPS = 512, ROUNDS = 4, PATIENCE = 1024 };

/* Distance from the limit that is plain, in units of sum |ds/dy_j| |y_j|: of rounding, and of the tolerance. */
static const double OF_ROUNDING = 6.4e4 * DBL_EPSILON, OF_TOLERANCE = 1e-5;

/* An event function on its limit, by its `side` (with the sign of that): to be decided, it stays, it leaves. */
static const double MARKED = 1.0, STAYS = 2.0, LEAVES = 3.0;

/* Scratch rows, behind the stages that dense output may still ask for. */
enum { STATE = GB_STAGES - 4, RATE };

/* The side of the limit on which event function i stands: -1 lower, 1 upper, else 0. */
static double stands_on(const gb_sim *sim, int i) {
    const double s = sim->events.s[i], lo = sim->events.lo[i], hi = sim->events.hi[i];
    const int below = lo > -HUGE_VAL && fabs(s - lo) <= 64.0 * DBL_EPSILON * fabs(lo) + DBL_MIN;
    const int above = hi < HUGE_VAL && fabs(s - hi) <= 64.0 * DBL_EPSILON * fabs(hi) + DBL_MIN;
    return below ? -1.0 : above ? 1.0 : 0.0;
}

/* Marks lossy gears at rest, closed stops and locked freewheels of which nothing is asked yet: any force lets the gear
 * slide, and its sign tells which way; the others hold against one sign and open by the other. */
static int mark_forces(gb_sim *sim) {
    int count = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        const gb_constraint *constraint = &sim->model->constraints[i];
        if (constraint->kind != GB_TIE && gb_is_active(sim, i) && sim->events.held_side[constraint->active] == 0.0) {
            sim->events.side[constraint->active] = stands_on(sim, constraint->active);
            count += sim->events.side[constraint->active] != 0.0;
        }
    }
    return count;
}

/* Marks those that stand on a limit, without having come there and without a slope; how many. */
static int mark(gb_sim *sim) {
    const gb_model *model = sim->model;
    int count = 0, code = gb_event_functions_now(sim);
    for (int i = 0; i < model->n_event_functions && code == GB_DONE; i++) {
        const int free = sim->events.role[i] == GB_ORDINARY && sim->events.armed[i] == 0.0;
        const double held = sim->events.held_side[i];
        sim->events.side[i] = held != 0.0 ? held : free ? stands_on(sim, i) : 0.0;
        count += sim->events.side[i] != 0.0;
    }
    for (int k = 0; k < model->n_exact_timed && code == GB_DONE; k++) { /* see gb_exact_limit.h */
        count -= sim->events.side[model->exact_switches[k]] != 0.0;
        sim->events.side[model->exact_switches[k]] = 0.0;
    }
    count += code == GB_DONE ? mark_forces(sim) : 0;
    if (code != GB_DONE || count == 0 || model->n_affine == 0) {
        return code == GB_DONE ? count : 0;
    }
    if (gb_time_terms_at(sim, sim->head->front.t1) != GB_DONE) {
        return 0;
    }
    model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->y, gb_scratch_row(sim, RATE));
    model->directions(sim->par, gb_scratch_row(sim, RATE), sim->events.slopes);
    for (int i = 0; i < model->n_affine; i++) {
        const int moves = sim->events.held_side[i] == 0.0 && sim->events.slopes[i] != 0.0;
        count -= moves && sim->events.side[i] != 0.0;
        sim->events.side[i] = moves ? 0.0 : sim->events.side[i];
    }
    return count;
}

/* sum |ds/dy_j| |y_j| of all event functions at the state that was followed, where they are events.s, into `located`;
 * of forces also what rounding leaves of them beside others, which loads over time bring with them. */
static void sizes(gb_sim *sim) {
    double *state = gb_scratch_row(sim, STATE), *moved = sim->events.moved, *size = sim->events.located;
    memset(size, 0, sizeof(double) * (size_t)sim->model->n_event_functions);
    for (int j = 0; j < sim->model->n; j++) {
        const double kept = state[j], change = 1e-6 * gb_max(fabs(kept), fabs(sim->y[j]));
        if (change > 0.0) {
            state[j] = kept + change;
            sim->model->event_functions(sim->par, sim->mode, sim->instant.time_terms, state, moved);
            for (int i = 0; i < sim->model->n_event_functions; i++) {
                size[i] += 1e6 * fabs(moved[i] - sim->events.s[i]);
            }
            state[j] = kept;
        }
    }
    for (int c = 0; c < sim->model->n_constraints; c++) {
        const int i = sim->model->constraints[c].active;
        double force;
        if (fabs(sim->events.side[i]) == MARKED) {
            size[i] += gb_force_rounding(sim, i, sim->instant.time_terms, state, &force) / OF_ROUNDING;
        }
    }
}

/* How far event function i, with the value s, is beyond its limit. */
static double outward(const gb_sim *sim, int i, double s) {
    const double side = sim->events.side[i];
    return side * (s - (side < 0.0 ? sim->events.lo[i] : sim->events.hi[i]));
}

/* What holds, and is not to be decided or stays for now, lets go before the state that was followed: the motion is
 * another one there. */
static int lets_go(const gb_sim *sim, double unit) {
    int found = 0;
    for (int c = 0; c < sim->model->n_constraints; c++) {
        const int i = sim->model->constraints[c].active;
        const int holds = sim->events.side[i] == 0.0 || fabs(sim->events.side[i]) == STAYS;
        found |= gb_is_active(sim, c) && holds && sim->events.s[i] - sim->events.hi[i] > unit * sim->events.located[i];
    }
    return found;
}

/* Looks `time` ahead and decides what is plain there, with so many steps that twice as many say the same; how much is
 * left to decide. */
static int look(gb_sim *sim, double time, int *left) {
    const size_t all = sizeof(double) * (size_t)sim->model->n_event_functions;
    const double unit = gb_max(OF_ROUNDING, OF_TOLERANCE * sim->head->options.rtol);
    double *state = gb_scratch_row(sim, STATE);
    int code = gb_follow_functions(sim, time, STEPS, state, sim->events.s0), doubt = 1;
    for (int steps = 2 * STEPS; steps <= MOST_STEPS && doubt && code == GB_DONE; steps *= 2) {
        code = gb_follow_functions(sim, time, steps, state, sim->events.s);
        if (code == GB_DONE) {
            sizes(sim);
        }
        if (code != GB_DONE || gb_passes_a_stop(sim, unit) || lets_go(sim, unit)) {
            *left = 0;
            return code;
        }
        doubt = *left = 0;
        for (int i = 0; i < sim->model->n_event_functions; i++) {
            if (fabs(sim->events.side[i]) != MARKED) {
                continue;
            }
            const double before = outward(sim, i, sim->events.s0[i]), off = outward(sim, i, sim->events.s[i]);
            const int plain = fabs(off) > unit * sim->events.located[i], sure = fabs(off - before) <= 0.3 * fabs(off);
            doubt |= plain && !sure;
            *left += !(plain && sure);
            if (plain && sure) {
                sim->events.side[i] *= off > 0.0 ? LEAVES : STAYS;
                sim->events.held[i] = sim->head->front.t1 + time;
            }
        }
        memcpy(sim->events.s0, sim->events.s, all);
    }
    return code;
}

/* Nothing that is marked moves at all. */
static int rests(gb_sim *sim, double longest) {
    double *state = gb_scratch_row(sim, STATE);
    int moves = gb_follow_functions(sim, longest, STEPS, state, sim->events.s) != GB_DONE;
    for (int i = 0; i < sim->model->n_event_functions; i++) {
        moves |= sim->events.side[i] != 0.0 && outward(sim, i, sim->events.s[i]) != 0.0;
    }
    return !moves;
}

/* What was held and of which nothing is plain yet is held on. */
static void hold_on(gb_sim *sim) {
    for (int i = 0; i < sim->model->n_event_functions; i++) {
        const int held = fabs(sim->events.side[i]) == MARKED && sim->events.held[i] > sim->head->front.t1;
        if (held && sim->events.role[i] == GB_ORDINARY) {
            gb_hold_limit(sim, i, sim->events.side[i], sim->events.held[i]);
        }
    }
    gb_mode_limits(sim);
}

/* Takes the modes behind the limits through which something leaves; how many. Limits of what stays are not watched.
 * What constraints do is decided by all of them together, by the motion so far ahead. */
static int take_modes(gb_sim *sim, int log) {
    struct gb_event_state *events = &sim->head->events;
    int flipped = 0;
    events->held_until = HUGE_VAL;
    events->look_ahead = 0.0;
    for (int i = 0; i < sim->model->n_event_functions; i++) {
        const double size = fabs(sim->events.side[i]), way = sim->events.side[i] < 0.0 ? -1.0 : 1.0;
        sim->events.held_side[i] = 0.0;
        flipped += size == LEAVES;
        if (size == LEAVES && sim->events.role[i] == GB_CONSTRAINED) {
            sim->events.pending[i] = way;
            events->look_ahead = gb_max(events->look_ahead, sim->events.held[i] - sim->head->front.t1);
        } else if (size == LEAVES) {
            gb_set_mode(sim, i, gb_far_side(sim, i, way), log);
        } else if (size == STAYS) {
            gb_hold_limit(sim, i, way, sim->events.held[i]);
        }
    }
    hold_on(sim);
    return flipped;
}

/* A force that should let go is still held: beside those of other parts, which the decision weighs too, it is rounding
 * so far. Where that is so, how far is to be looked next. */
static double further(const gb_sim *sim) {
    double time = 0.0;
    for (int i = 0; i < sim->model->n_constraints && sim->head->events.look_ahead > 0.0; i++) {
        const int left = fabs(sim->events.side[sim->model->constraints[i].active]) == LEAVES;
        time = left && gb_is_active(sim, i) ? FURTHER * sim->head->events.look_ahead : time;
    }
    return time;
}

/* What has begun to slide or has opened: its direction and the side of its force stay those that were found as far
 * ahead as it took. */
static void hold_begun(gb_sim *sim) {
    const double time = sim->head->front.t1 + sim->head->events.look_ahead;
    for (int i = 0; i < sim->model->n_event_functions && sim->head->events.look_ahead > 0.0; i++) {
        const int opened = sim->events.role[i] == GB_CONSTRAINED && fabs(sim->events.side[i]) == MARKED;
        if (opened) { /* in a round before, and it moves only now */
            gb_hold_limit(sim, i, sim->events.side[i], time);
        }
    }
    for (int i = 0; i < sim->model->n_constraints && sim->head->events.look_ahead > 0.0; i++) {
        const gb_constraint *constraint = &sim->model->constraints[i];
        const int left = fabs(sim->events.side[constraint->active]) == LEAVES && !gb_is_active(sim, i);
        const int slip = constraint->slip;
        const int sign = constraint->kind == GB_LOSS ? sim->model->constraints[constraint->partner].slip : slip;
        if (left && constraint->kind == GB_STOP) {
            gb_hold_limit(sim, slip, -1.0, time);
        } else if (left) {
            gb_hold_limit(sim, slip, -sim->mode[slip], time);
        }
        if (left && constraint->kind == GB_LOSS) {
            gb_hold_limit(sim, sign, -sim->mode[sign], time);
        }
    }
    sim->head->events.look_ahead = 0.0;
    gb_mode_limits(sim);
}

/* Nothing is held any more. */
static void release(gb_sim *sim) {
    if (sim->head->events.held_until < HUGE_VAL) {
        memset(sim->events.held_side, 0, sizeof(double) * (size_t)sim->model->n_switches);
        sim->head->events.held_until = HUGE_VAL;
        gb_mode_limits(sim);
    }
}

/* One round: marks, looks ahead from `shortest` on, takes modes; how many flipped. Where all that is marked rests, the
 * next look waits. */
static int decide(gb_sim *sim, int log, double shortest, int *flipped) {
    struct gb_event_state *events = &sim->head->events;
    const double longest = gb_min(LONGEST, events->t_break - sim->head->front.t1);
    int left = mark(sim), code = GB_DONE;
    *flipped = 0;
    release(sim);
    if (left == 0 || !(longest > shortest)) {
        return GB_DONE;
    }
    if (rests(sim, longest)) {
        events->look_gap = events->look_gap < PATIENCE ? 2 * events->look_gap + 1 : PATIENCE;
        events->look_at = sim->head->counts.events + events->look_gap;
        hold_on(sim);
        return GB_DONE;
    }
    events->look_gap = 0;
    for (double time = shortest; time <= longest && left > 0 && code == GB_DONE; time *= FURTHER) {
        code = look(sim, time, &left);
    }
    if (code == GB_DONE) {
        *flipped = take_modes(sim, log);
    }
    return code;
}

/* Every mode drives what has just flipped back: it slides there, or nothing moves on. */
static int hold_trapped(gb_sim *sim) {
    int last = 0;
    for (int i = 0; i < sim->model->n_event_functions; i++) {
        last = fabs(sim->events.side[i]) == LEAVES ? i : last;
    }
    if (sim->events.role[last] == GB_CONSTRAINED) { /* constraints have a limit of flips of their own */
        return GB_DONE;
    }
    return gb_slide(sim, last) || gb_come_to_rest(sim, last, 0.0, 0) || gb_hold(sim, last, 0.0)
               ? GB_DONE
               : gb_fail(sim, GB_ERR_CHATTER, last, sim->head->front.t1, ROUNDS);
}

int gb_depart(gb_sim *sim, int before, int timed) {
    const gb_model *model = sim->model;
    const struct gb_event_state *events = &sim->head->events;
    const int held = events->held_until < HUGE_VAL, log = before == GB_AT_EVENT;
    int code = GB_DONE, flipped = 1, left = 0, early = log && !timed && sim->head->counts.events < events->look_at;
    double shortest = SHORTEST, ahead = 0.0;
    if (!sim->head->options.locate || model->n_event_functions == 0 || (early && !held)) {
        return GB_DONE;
    }
    for (int round = 0; round < ROUNDS && flipped > 0 && code == GB_DONE; round++) {
        if (model->update_states != NULL) {
            memcpy(sim->events.mode_before, sim->mode, sizeof(double) * (size_t)model->n_switches);
        }
        code = decide(sim, log, shortest, &flipped);
        if (code == GB_DONE && flipped > 0) {
            left = 1;
            ahead = sim->head->events.look_ahead = gb_max(sim->head->events.look_ahead, ahead);
            sim->head->front.have_k1 = 0;
            code = model->n_constraints > 0 ? gb_settle_all(sim, log) : gb_settle_modes(sim, log);
            shortest = further(sim);
            round -= shortest > 0.0;
            shortest = gb_max(shortest, SHORTEST);
            hold_begun(sim);
        }
        if (code == GB_DONE && flipped > 0) {
            code = gb_balance_massless(sim, before);
        }
        if (code == GB_DONE && flipped > 0 && model->update_states != NULL) {
            code = gb_update_states(sim);
        }
    }
    code = code == GB_DONE && flipped > 0 ? hold_trapped(sim) : code;
    return code == GB_DONE && left ? gb_settle_exact_limits(sim, log) : code;
}
