#include "gb_constraint_switching.h"
#include "gb_constraint_forces.h"
#include "gb_constraint_state.h"
#include "gb_constraints.h"
#include "gb_evaluate.h"
#include "gb_flight.h"
#include "gb_follow.h"
#include "gb_impact.h"
#include "gb_loss.h"
#include "gb_lossy_gear.h"
#include "gb_modes.h"
#include "gb_report.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

/* Flips that a look ahead stands for, where the force of a lossy gear has just come to zero. */
static const double SIGN_AHEAD = 8.0;

/* Steps of a look ahead: four times as many links of a train carry a load on. */
enum { LOOK_STEPS = 8 };

/* Mode for the events: 0 stuck, 1 forward, -1 backward, 2 free; of a stop 1 closed, 0 open. */
static double shown_mode(const gb_sim *sim, int i) {
    const gb_constraint *constraint = &sim->model->constraints[i];
    if (constraint->kind == GB_STOP || constraint->kind == GB_TIE) {
        return sim->mode[constraint->active];
    }
    return gb_is_active(sim, i) ? 0.0 : sim->mode[constraint->slip] == 0.0 ? 2.0 : sim->mode[constraint->slip];
}

/* What each constraint could do, by its slip alone; what slides gets its direction. */
static void sort_by_slip(gb_sim *sim, int impacted) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_constraints; i++) {
        const gb_constraint *constraint = &model->constraints[i];
        const double slip = sim->constraints.slip[i], rounding = sim->constraints.slip_rounding[i];
        const int pending = constraint->kind != GB_STOP && sim->events.pending[constraint->slip] != 0.0 && !impacted;
        /* another switch changed its mode where this one has just let go, at its limit: it has been decided */
        const int goes_on = sim->constraints.was_broken[i] && sim->events.armed[constraint->slip] != 0.0 && !pending;
        const int zero = (fabs(slip) <= rounding && !goes_on) || pending || (gb_is_active(sim, i) && !impacted);
        int *state = &sim->constraints.decision[i];
        const double held = gb_is_active(sim, i) || impacted ? 0.0 : sim->events.held_side[constraint->slip];
        sim->mode[constraint->slip] = constraint->kind == GB_TIE ? sim->mode[constraint->slip] : 0.0;
        if (held != 0.0 && constraint->kind != GB_TIE) { /* a look ahead has told */
            *state = constraint->kind == GB_STOP ? GB_IS_OPEN : GB_SLIDES;
            sim->mode[constraint->slip] = constraint->kind == GB_STOP ? 0.0 : -held;
        } else if (!gb_is_engaged(sim, i)) {
            *state = GB_FREE;
        } else if (constraint->kind == GB_STOP) {
            const int rests =
                fabs(slip) <= rounding || (gb_is_active(sim, i) && !impacted) ||
                (sim->constraints.struck[i] && fabs(slip) <= 1e-9 * fabs(sim->constraints.slip_before[i])) ||
                (impacted && gb_opens_for_nothing(sim, i));
            *state = gb_touches(sim, i) && rests ? GB_CANDIDATE : GB_IS_OPEN;
        } else if (zero || gb_is_unbounded(sim, i)) {
            *state = GB_CANDIDATE;
        } else { /* one that has just begun to slide is still about its limit: the sign of the slip there is rounding */
            const double begun = impacted ? 0.0 : -sim->events.armed[constraint->slip];
            const double direction = begun != 0.0 ? begun : slip > 0.0 ? 1.0 : -1.0;
            *state = gb_is_blocked(sim, i, direction) ? GB_CANDIDATE : GB_SLIDES;
            sim->mode[constraint->slip] = *state == GB_SLIDES ? direction : 0.0;
        }
    }
}

/* A constraint whose force has just reached a bound (and which is not redundant) is not active any more. */
static void release_pending(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_constraints; i++) {
        const gb_constraint *constraint = &model->constraints[i];
        if (sim->constraints.decision[i] != GB_CANDIDATE || sim->events.pending[constraint->active] == 0.0) {
            continue;
        }
        const double force = sim->constraints.other[i], *bounds = sim->constraints.bounds + 5 * i;
        if (sim->constraints.was_redundant[i]) {
            sim->constraints.shrink[i] = 1e-6;
            continue;
        }
        const int upper = constraint->kind == GB_LOSS ? gb_loss_is_upper(sim, i, sim->constraints.other)
                                                      : force - bounds[1] > bounds[0] - force;
        sim->constraints.decision[i] = constraint->kind == GB_STOP ? GB_IS_OPEN : GB_SLIDES;
        sim->mode[constraint->slip] = constraint->kind == GB_STOP ? 0.0 : upper ? -1.0 : 1.0;
        sim->constraints.released[i] = 1;
    }
}

/* The modes of what was decided, and from which limits their switches are watched. */
static void take_modes(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_constraints; i++) {
        const gb_constraint *constraint = &model->constraints[i];
        const double direction = sim->mode[constraint->slip];
        sim->mode[constraint->active] = sim->constraints.decision[i] == GB_CANDIDATE;
        sim->events.armed[constraint->active] = 0.0;
        if (constraint->kind == GB_TIE) {
            sim->events.armed[constraint->slip] = sim->events.pending[constraint->slip] != 0.0 ? -direction : 0.0;
        } else if (constraint->kind == GB_STOP) {
            sim->events.armed[constraint->slip] =
                sim->constraints.decision[i] == GB_IS_OPEN && gb_touches(sim, i) ? -1.0 : 0.0;
        } else {
            const int on_limit =
                sim->constraints.decision[i] == GB_SLIDES &&
                (sim->constraints.released[i] || fabs(sim->constraints.slip[i]) <= sim->constraints.slip_rounding[i] ||
                 sim->events.pending[constraint->slip] != 0.0);
            sim->events.armed[constraint->slip] = on_limit ? -direction : 0.0;
        }
        if (sim->events.armed[constraint->slip] != 0.0) {
            sim->head->events.armed = 1;
        }
    }
}

/* A switch of constraint i was pending and nothing came of it: it counts as a flip, so that the same does not come back
 * for ever where event functions leave their limits no faster than rounding. */
static int count_vain(gb_sim *sim, int i) {
    const gb_constraint *constraint = &sim->model->constraints[i];
    const int slip = sim->events.pending[constraint->slip] != 0.0,
              active = sim->events.pending[constraint->active] != 0.0;
    const int code = slip ? gb_count_flip(sim, constraint->slip) : GB_DONE;
    return code == GB_DONE && active ? gb_count_flip(sim, constraint->active) : code;
}

/* It held before and does not any more: what it held at rest on a limit may leave that now. */
static int lets_go(const gb_constraint *constraint, double before, double now) {
    return constraint->kind == GB_STOP ? before == 1.0 && now == 0.0 : before == 0.0 && now != 0.0;
}

/* Events of the constraints whose mode is another one than before. */
static int log_changes(gb_sim *sim, int log) {
    const gb_model *model = sim->model;
    int code = GB_DONE;
    for (int i = 0; i < model->n_constraints; i++) {
        const gb_constraint *constraint = &model->constraints[i];
        const double now = shown_mode(sim, i), before = sim->constraints.mode_before[i];
        if (now != before) {
            if (lets_go(constraint, before, now)) {
                sim->head->events.look_at = 0;
            }
            if (log && !(constraint->kind == GB_STOP && sim->constraints.struck[i])) {
                gb_log(sim, constraint->slip, 0, before, now);
            }
            const int one_way = gb_is_blocked(sim, i, 1.0) || gb_is_blocked(sim, i, -1.0);
            if (!log && !one_way) { /* what breaks at a start stays broken; a one-way lock may hold again */
                sim->events.flip_time[constraint->active] = sim->head->front.t1;
            } else if (log && code == GB_DONE) {
                code = gb_count_flip(sim, constraint->active);
            }
        } else if (log && code == GB_DONE && !sim->constraints.struck[i]) {
            code = count_vain(sim, i);
        }
        if (sim->constraints.struck[i]) {
            sim->events.flip_time[constraint->slip] = sim->head->front.t1;
        }
        sim->events.pending[constraint->slip] = sim->events.pending[constraint->active] = 0.0;
    }
    return code;
}

/* It slides since this very instant: it does not hold its static peak again before time has gone on. */
static int has_just_let_go(const gb_sim *sim, int i) {
    const gb_constraint *constraint = &sim->model->constraints[i];
    return constraint->kind == GB_FRICTION && !gb_is_active(sim, i) && sim->mode[constraint->slip] != 0.0 &&
           gb_flips_at_front(sim, constraint->active);
}

/* Constraint forces of the old modes, and which of them were redundant, before anything changes. */
static void look_back(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int n = model->n_constraints;
    for (int i = 0; i < n; i++) {
        sim->constraints.mode_before[i] = shown_mode(sim, i);
        sim->constraints.was_redundant[i] =
            sim->mode[model->n_switches] > 0.0 && sim->mode[model->n_switches + gb_active_redundant(n) + i] != 0.0;
        sim->constraints.shrink[i] = 0.0;
        sim->constraints.released[i] = sim->constraints.struck[i] = 0;
        sim->constraints.was_broken[i] = has_just_let_go(sim, i);
    }
    model->constraint_forces(sim->par, sim->mode, sim->instant.time_terms, sim->constraints.y, sim->constraints.other,
                             sim->constraints.force);
}

/* A capacity that comes to zero at a corner and stays there crosses nothing: its constraint is free all the same. */
static void free_the_disengaged(gb_sim *sim) {
    for (int i = 0; i < sim->model->n_constraints; i++) {
        const int free = sim->model->constraints[i].free;
        if (free >= 0 && sim->mode[free] < 0.5 && !gb_is_engaged(sim, i)) {
            gb_set_mode(sim, free, 1.0, 0);
        }
    }
}

/* A constraint that flips again at once stands where forces and bounds vanish together: a look a little ahead, further
 * at every try, tells what comes next. The state there is constraints.y, its time terms are those of `instant`. */
static int look_ahead(gb_sim *sim) {
    const gb_model *model = sim->model;
    const gb_head *head = sim->head;
    double flips = 0.0;
    for (int i = 0; i < model->n_constraints; i++) {
        const gb_constraint *constraint = &model->constraints[i];
        const int pending =
            sim->events.pending[constraint->active] != 0.0 || sim->events.pending[constraint->slip] != 0.0;
        const int stands = gb_flips_at_front(sim, constraint->active);
        flips = pending && stands ? gb_max(flips, sim->events.flips[constraint->active]) : flips;
        if (constraint->kind == GB_TIE && sim->events.pending[constraint->slip] != 0.0) {
            flips = gb_max(flips, SIGN_AHEAD); /* the force is 0 there; what it does next tells its sign */
        }
    }
    sim->constraints.y = sim->y;
    const double told = head->events.look_ahead;
    if (flips == 0.0 && told == 0.0) {
        return GB_DONE;
    }
    const double ahead = told > 0.0 ? told : ldexp(gb_rounding(head->front.t1, head->front.h), 2 * (int)flips);
    const int code = gb_follow_finite(sim, ahead, LOOK_STEPS, sim->z);
    sim->constraints.y = code == GB_DONE ? sim->z : sim->y;
    return code;
}

/* How long the first of the bodies that have just hit a stop stays away from it. Friction may turn its pace on the way:
 * the same counts then, for a while. */
static void note_flight(gb_sim *sim) {
    struct gb_event_state *events = &sim->head->events;
    double shortest = HUGE_VAL;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        double size;
        const double rate = gb_slip_acceleration(sim, i, &size);
        if (gb_is_stop(sim, i) && sim->constraints.struck[i] && sim->constraints.decision[i] == GB_IS_OPEN &&
            rate < 0.0) {
            shortest = gb_min(shortest, -2.0 * sim->constraints.slip[i] / rate);
        }
    }
    if (shortest < HUGE_VAL) {
        events->flight = shortest;
        events->flight_end = sim->head->front.t1 + 16.0 * shortest;
    } else if (!(events->flight > 0.0 && sim->head->front.t1 < events->flight_end)) {
        events->flight = HUGE_VAL;
    }
}

/* A stop that a start value lies beyond, or a lossy gear whose sides start at speeds that it does not allow; or -1.
 * 1e-9 of what is given counts as rounding. */
static int begins_beyond(const gb_sim *sim) {
    const gb_model *model = sim->model;
    double size = 0.0, speed = 0.0;
    for (int i = model->n - model->n_speeds; i < model->n; i++) {
        speed = gb_max(speed, fabs(sim->y[i]));
    }
    for (int i = 0; i < model->n - model->n_speeds; i++) {
        size = gb_max(size, fabs(sim->y[i]));
    }
    for (int i = 0; i < model->n_constraints; i++) {
        if (gb_is_stop(sim, i) && sim->events.s[model->constraints[i].slip] < -1e-9 * size - 1e-15) {
            return i;
        }
        if (model->constraints[i].kind == GB_TIE &&
            fabs(sim->constraints.slip[i]) > 1e-9 * speed * sim->constraints.row_size[i]) {
            return i;
        }
    }
    return -1;
}

/* Event functions, time terms and slips at the front, and the state by which it is decided. */
static int look_at_front(gb_sim *sim, int log) {
    int code = gb_event_functions_now(sim);
    if (code == GB_DONE) {
        code = gb_time_terms_at(sim, sim->head->front.t1);
    }
    if (code == GB_DONE) {
        gb_slips_now(sim);
    }
    const int beyond = code == GB_DONE && !log ? begins_beyond(sim) : -1;
    if (beyond >= 0) {
        const int slip = sim->model->constraints[beyond].slip;
        return gb_fail(sim, GB_ERR_BEYOND, slip, sim->head->front.t1, sim->events.s[slip]);
    }
    if (code == GB_DONE) {
        gb_project_velocities(sim, sim->instant.time_terms);
        code = look_ahead(sim);
    }
    return code;
}

/* Slips and impacts are those of the front, although a look ahead decides by the forces of a later instant: a motion
 * that is given moves on until then, and what it carries along would strike it again and again. */
static int strike_at_front(gb_sim *sim) {
    const double ahead = sim->instant.t[0];
    const int looks = sim->constraints.y != sim->y;
    int code = looks ? gb_time_terms_at(sim, sim->head->front.t1) : GB_DONE;
    if (code == GB_DONE) {
        gb_slips_now(sim);
        code = gb_impact(sim);
    }
    return looks && code == GB_DONE ? gb_time_terms_at(sim, ahead) : code;
}

/* Impacts, then forces: what each constraint does from here. */
static int decide(gb_sim *sim, int starting) {
    const gb_model *model = sim->model;
    look_back(sim);
    double *force = sim->constraints.force_before;
    memcpy(force, sim->constraints.other, sizeof(double) * (size_t)model->n_constraints);
    for (int i = 0; i < model->n_constraints; i++) {
        if (gb_is_active(sim, i) && model->constraints[i].kind != GB_TIE && !gb_is_stop(sim, i)) {
            sim->mode[model->constraints[i].slip] = 0.0;
        }
    }
    gb_read_bounds(sim, sim->constraints.y);
    free_the_disengaged(sim);
    int code = strike_at_front(sim), impacted = 0;
    for (int i = 0; i < model->n_constraints; i++) {
        impacted = impacted || sim->constraints.struck[i];
    }
    sort_by_slip(sim, impacted);
    if (starting || impacted) {
        gb_modes_at_slips(sim, !starting);
    }
    gb_read_bounds(sim, sim->constraints.y);
    memcpy(sim->constraints.other, force, sizeof(double) * (size_t)model->n_constraints);
    release_pending(sim);
    if (code == GB_DONE) {
        code = gb_has_lossy(sim) ? gb_choose_lossy(sim, starting) : gb_choose_active_set(sim);
    }
    return code;
}

int gb_switch_constraints(gb_sim *sim, int log) {
    const gb_model *model = sim->model;
    if (model->n_constraints == 0) {
        return GB_DONE;
    }
    int code = look_at_front(sim, log);
    if (code != GB_DONE) {
        return code;
    }
    code = decide(sim, !log);
    if (sim->constraints.y != sim->y && code == GB_DONE) {
        code = gb_time_terms_at(sim, sim->head->front.t1);
    }
    note_flight(sim);
    take_modes(sim);
    gb_factor_active_set(sim, sim->mode, sim->instant.time_terms, sim->y);
    gb_project_velocities(sim, sim->instant.time_terms);
    gb_rehash(sim);
    if (model->n_switches > 0) {
        gb_mode_limits(sim);
    }
    const int changes = log_changes(sim, log);
    return code == GB_DONE ? changes : code;
}
