#include "gb_impact.h"
#include "gb_constraint_state.h"
#include "gb_flight.h"
#include "gb_limit_noise.h"
#include "gb_report.h"
#include "gb_vector.h"

/* Rounds of an impact; and those in which a stop was left out because it is being left, before they have no end. */
enum { ROUNDS = 10000, LEAVING_ROUNDS = 32 };

/* In the report of an impact without an end: no number of flips. */
static const double STRUCK_BACK = 0.5;

/* Bounds of the impulse of constraint i and the slip that it must undo; 0: it takes no part. What opens just now does
 * not close: an impulse along it would do work on what leaves (lambda v- > 0) and give a train energy from nowhere.
 * endless: all contacts come to rest on each other. */
static int takes_impulse(gb_sim *sim, int i, int endless, double *lo, double *hi, double *undo) {
    const double slip = sim->constraints.slip[i], *bounds = sim->constraints.bounds + 5 * i;
    *lo = bounds[0] <= -HUGE_VAL ? -HUGE_VAL : 0.0;
    *hi = bounds[1] >= HUGE_VAL ? HUGE_VAL : 0.0;
    *undo = slip;
    if (!gb_is_engaged(sim, i) || sim->model->constraints[i].kind == GB_LOSS || (*lo == 0.0 && *hi == 0.0)) {
        return 0;
    }
    if ((*lo == 0.0 && slip > sim->constraints.slip_rounding[i]) ||
        (*hi == 0.0 && slip < -sim->constraints.slip_rounding[i])) {
        return 0;
    }
    if (gb_is_stop(sim, i)) {
        const int strikes = slip < -sim->constraints.slip_rounding[i] && !endless;
        *undo = strikes ? slip * (1.0 + gb_restitution(sim, i)) : slip;
        return gb_touches(sim, i);
    }
    return 1;
}

/* What constraint i loses at once. */
static void note_loss(gb_sim *sim, int i, double lost) {
    const gb_constraint *constraint = &sim->model->constraints[i];
    if (constraint->loss >= 0) {
        sim->y[constraint->loss] += lost;
        sim->head->ledger.turnover += fabs(lost);
    }
    if (constraint->heat > 0) {
        sim->y[constraint->heat - 1] += lost;
    }
}

/* What an impact did to constraint i: its loss, states and event. */
static void note_impact(gb_sim *sim, int i, double impulse, double before, double after) {
    const gb_constraint *constraint = &sim->model->constraints[i];
    double *speed = sim->constraints.impact_speed + 2 * i;
    sim->constraints.impacts[i] += 1.0;
    const unsigned long count = (unsigned long)sim->constraints.impacts[i];
    if ((count & (count - 1)) == 0) {
        speed[1] = speed[0];
        speed[0] = fabs(before);
    }
    if (constraint->impulse >= 0) {
        sim->y[constraint->impulse] = impulse;
    }
    if (constraint->impacts >= 0) {
        sim->y[constraint->impacts] += 1.0;
    }
    note_loss(sim, i, -0.5 * impulse * (before + after));
    gb_log(sim, constraint->slip, 2, before, after);
}

/* Applies impulses along the constraints; what prescribed motions supply to them counts as turnover. */
static void apply_impulses(gb_sim *sim, const double *impulse) {
    const gb_model *model = sim->model;
    memcpy(sim->z2, sim->y, sizeof(double) * (size_t)model->n_total);
    model->apply_impulses(sim->par, sim->mode, sim->instant.time_terms, impulse, sim->y);
    for (int i = model->n_padded + model->n_angles; i < model->n_padded + model->n_quadratures; i++) {
        sim->head->ledger.turnover += fabs(sim->y[i] - sim->z2[i]);
    }
}

/* Slips after an impact. Their rounding is that of the speeds that it took (where all bodies come to rest at once, what
 * is left of the speeds is nothing but that, and would tell directions of sliding), and that of what the impulses do to
 * them: two from both sides cancel on a light body that would fly far from either. */
static void slips_after(gb_sim *sim) {
    const double speed = sim->constraints.slip_rounding[0] / sim->constraints.row_size[0];
    const gb_delassus W = gb_delassus_of(sim);
    gb_slips_now(sim);
    for (int i = 0; i < sim->model->n_constraints; i++) {
        double terms = 0.0, *rounding = &sim->constraints.slip_rounding[i];
        gb_delassus_product(&W, i, sim->constraints.other, &terms);
        *rounding = gb_max(*rounding, gb_max(speed * sim->constraints.row_size[i], 16.0 * DBL_EPSILON * terms));
    }
}

/* The slip of lock i, which is bounded, has just come to zero. */
static int ends_slip(const gb_sim *sim, int i) {
    const gb_constraint *constraint = &sim->model->constraints[i];
    return constraint->kind == GB_FRICTION && !gb_is_unbounded(sim, i) && gb_is_engaged(sim, i) &&
           sim->events.pending[constraint->slip] != 0.0;
}

/* What the impulses of a round did: which constraints were struck, and the largest slip at which they were. */
static void note_round(gb_sim *sim, const double *impulse, const double *before) {
    const gb_delassus W = gb_delassus_of(sim);
    for (int i = 0; i < sim->model->n_constraints; i++) {
        const double rounding = sim->constraints.slip_rounding[i], own = fabs(impulse[i]) * gb_delassus_diagonal(&W, i);
        if (!(fabs(before[i]) > rounding && own > 1e-6 * fabs(before[i]) && fabs(impulse[i]) > 0.0) ||
            ends_slip(sim, i)) {
            continue;
        }
        note_impact(sim, i, impulse[i], before[i], sim->constraints.slip[i]);
        const double earlier = sim->constraints.struck[i] ? sim->constraints.slip_before[i] : 0.0;
        sim->constraints.slip_before[i] = gb_max(earlier, fabs(before[i]));
        sim->constraints.struck[i] = fabs(sim->constraints.slip[i]) <= rounding ? GB_STRUCK_TO_REST : GB_STRUCK;
    }
}

/* Takes the stops that are being left out of the round. */
static void leave_out(gb_sim *sim, int *left) {
    int any = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        if (sim->constraints.in[i] && gb_is_being_left(sim, i)) {
            sim->constraints.in[i] = 0;
            any = 1;
        }
    }
    *left += any;
}

/* Of the rounding of a slip: an impact that is no larger changes nothing that a lock holds. */
static const double TINY = 16.0;

/* Lock i is bounded and holds. */
static int holds(const gb_sim *sim, int i) {
    return sim->model->constraints[i].kind == GB_FRICTION && !gb_is_unbounded(sim, i) && gb_is_active(sim, i);
}

/* Locks that hold take part, one-way ones both ways, where what is left of the flights is rounding: they would give
 * back the speed that the stop takes, at one instant for ever, or their slip would open another stop. */
static void hold_at_the_end(gb_sim *sim) {
    int any = 0, large = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        const double slip = sim->constraints.slip[i], rounding = sim->constraints.slip_rounding[i];
        if (sim->constraints.in[i] && gb_is_stop(sim, i) && slip < -rounding) {
            any = 1;
            large |= slip < -TINY * rounding && !gb_ends_for_nothing(sim, i);
        }
    }
    for (int i = 0; i < sim->model->n_constraints && any && !large; i++) {
        if (sim->model->constraints[i].kind == GB_FRICTION && gb_is_active(sim, i)) {
            sim->constraints.in[i] = 1;
            sim->constraints.lo[i] = -HUGE_VAL;
            sim->constraints.hi[i] = HUGE_VAL;
            sim->constraints.right[i] = sim->constraints.slip[i];
        }
    }
}

/* Which constraints take part in the next round of an impact, and the one that is hit hardest, or -1 where none is.
 * What took part in the round before is right but for rounding. left: rounds so far that went on without a stop that is
 * being left; they would have no end where that takes no speed, and their limit is rest of all that touches. */
static int find_hit(gb_sim *sim, int round, int *left) {
    double *b = sim->constraints.right, *lo = sim->constraints.lo, *hi = sim->constraints.hi, most = 0.0;
    int hit = -1;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        const int was_in = round > 0 && sim->constraints.in[i];
        sim->constraints.in[i] = takes_impulse(sim, i, *left > LEAVING_ROUNDS, &lo[i], &hi[i], &b[i]);
        if (sim->constraints.in[i] && !was_in) {
            const gb_constraint *constraint = &sim->model->constraints[i];
            const int met = constraint->kind == GB_FRICTION &&
                            sim->events.pending[constraint->slip] != 0.0; /* its slip has just come to zero */
            const double w = met ? 0.0 : b[i], rounding = sim->constraints.slip_rounding[i];
            if (((w < -rounding && hi[i] > 0.0) || (w > rounding && lo[i] < 0.0)) && fabs(w) > most) {
                most = fabs(w);
                hit = i;
            }
        }
    }
    if (hit >= 0 && *left <= LEAVING_ROUNDS) {
        leave_out(sim, left);
    }
    if (hit >= 0) {
        hold_at_the_end(sim);
    }
    return hit;
}

static int finds_impulses(gb_sim *sim) {
    return gb_solve_problem(sim, 0) == GB_DONE && gb_refuse_contradiction(sim, 0.0) == GB_DONE;
}

/* The stops of this round throw nothing back: as much as they can ask for together. */
static void make_plastic(gb_sim *sim) {
    for (int i = 0; i < sim->model->n_constraints; i++) {
        if (sim->constraints.in[i] && gb_is_stop(sim, i)) {
            sim->constraints.right[i] = sim->constraints.slip[i];
        }
    }
    sim->head->report.code = GB_DONE;
}

/* The impulses of a round that is set up, into constraints.other; slips before it are in free_acceleration. Between two
 * stops that leave no room, no speed is the one that either throws back: what is left of it is taken. */
static int strike(gb_sim *sim) {
    const size_t size = sizeof(double) * (size_t)sim->model->n_constraints;
    sim->model->delassus(sim->par, sim->mode, sim->instant.time_terms, sim->y, 0, sim->constraints.delassus);
    if (!finds_impulses(sim)) {
        make_plastic(sim);
        if (!finds_impulses(sim)) {
            return sim->head->report.code;
        }
    }
    memcpy(sim->constraints.other, sim->constraints.force, size);
    memcpy(sim->constraints.free_acceleration, sim->constraints.slip, size);
    apply_impulses(sim, sim->constraints.other);
    slips_after(sim);
    return GB_DONE;
}

/* An impact elsewhere has opened stop i for nothing. */
static int is_opened_for_nothing(gb_sim *sim, int i) {
    return gb_is_stop(sim, i) && sim->constraints.slip[i] > sim->constraints.slip_rounding[i] && gb_touches(sim, i) &&
           gb_opens_for_nothing(sim, i);
}

static int any_opened_for_nothing(gb_sim *sim) {
    int any = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        any |= is_opened_for_nothing(sim, i);
    }
    return any;
}

/* The round in which they close, beside what has been closed so in rounds before and the locks that still hold:
 * impulses of all of these have no bound. */
static void set_up_closing(gb_sim *sim) {
    double *b = sim->constraints.right, *lo = sim->constraints.lo, *hi = sim->constraints.hi;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        const int closed = gb_is_stop(sim, i) && sim->constraints.in[i] && lo[i] <= -HUGE_VAL;
        const int sticks = holds(sim, i) && fabs(sim->constraints.slip[i]) <= sim->constraints.slip_rounding[i];
        sim->constraints.in[i] = takes_impulse(sim, i, 1, &lo[i], &hi[i], &b[i]);
        if (closed || sticks || is_opened_for_nothing(sim, i)) {
            sim->constraints.in[i] = 1;
            lo[i] = -HUGE_VAL;
            hi[i] = HUGE_VAL;
            b[i] = sim->constraints.slip[i];
        }
    }
}

/* What an impact elsewhere opens for nothing stays closed: the bodies share their momentum, as they do in a flight that
 * ends at once; that may open the next one of a row. No event. any: whether there was such a contact; what it drives
 * back is struck again. */
static int close_what_opens_for_nothing(gb_sim *sim, int *any) {
    *any = 0;
    for (int pass = 0; pass < sim->model->n_constraints && any_opened_for_nothing(sim); pass++) {
        *any = 1;
        set_up_closing(sim);
        if (strike(sim) != GB_DONE) {
            return sim->head->report.code;
        }
        for (int i = 0; i < sim->model->n_constraints; i++) {
            const double mean = 0.5 * (sim->constraints.free_acceleration[i] + sim->constraints.slip[i]);
            note_loss(sim, i, -sim->constraints.other[i] * mean);
        }
    }
    return GB_DONE;
}

/* A body that lies at an open stop, unpressed, off it by no more than the rounding of their angles, has not left it:
 * what strikes it finds both. Whether there is such a stop. */
static int lies_at_a_stop(gb_sim *sim) {
    int any = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        const int gap = sim->model->constraints[i].slip;
        if (gb_is_stop(sim, i) && !gb_touches(sim, i) &&
            fabs(sim->constraints.slip[i]) <= sim->constraints.slip_rounding[i] &&
            gb_is_noise(sim, gap, sim->events.s[gap], sim->instant.time_terms, sim->y, sim->y)) {
            sim->events.armed[gap] = -1.0;
            any = 1;
        }
    }
    return any;
}

/* What an impact leaves of the slips that it brought to rest is rounding: a speed into a stop that nothing presses
 * would strike it for ever. */
static void settle(gb_sim *sim) {
    const gb_model *model = sim->model;
    double *mode = sim->mode, *was = sim->constraints.right;
    for (int i = 0; i < model->n_constraints; i++) {
        const int active = model->constraints[i].active;
        was[i] = mode[active];
        mode[active] = sim->constraints.in[i] && fabs(sim->constraints.slip[i]) <= sim->constraints.slip_rounding[i];
    }
    gb_factor_active_set(sim, mode, sim->instant.time_terms, sim->y);
    gb_project_velocities(sim, sim->instant.time_terms);
    for (int i = 0; i < model->n_constraints; i++) {
        mode[model->constraints[i].active] = was[i];
    }
    gb_factor_active_set(sim, mode, sim->instant.time_terms, sim->y);
    slips_after(sim);
}

/* A stop that has struck in this impact throws less than all back. */
static int any_loses(const gb_sim *sim) {
    int any = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        any |= gb_is_stop(sim, i) && sim->constraints.struck[i] && sim->constraints.bounds[5 * i + 2] < 1.0;
    }
    return any;
}

int gb_impact(gb_sim *sim) {
    const gb_model *model = sim->model;
    const double *impulse = sim->constraints.other, *before = sim->constraints.free_acceleration;
    int left = 0, hit = find_hit(sim, 0, &left);
    if (hit >= 0 && lies_at_a_stop(sim)) {
        left = 0;
        hit = find_hit(sim, 0, &left);
    }
    for (int round = 0; hit >= 0; round++) {
        int closed = 0;
        if (round == 2 * ROUNDS || (round == ROUNDS && !any_loses(sim))) {
            return gb_fail(sim, GB_ERR_CHATTER, model->constraints[hit].slip, sim->head->front.t1, STRUCK_BACK);
        }
        sim->head->control.h_trusted = 0.0; /* what comes is another motion: no step of it has been looked into */
        if (strike(sim) != GB_DONE) {
            return sim->head->report.code;
        }
        note_round(sim, impulse, before);
        left = round == ROUNDS ? LEAVING_ROUNDS + 1 : left; /* little is lost, and the end is the same */
        hit = find_hit(sim, round + 1, &left);
        if (hit < 0 && close_what_opens_for_nothing(sim, &closed) != GB_DONE) {
            return sim->head->report.code;
        }
        hit = closed ? find_hit(sim, round + 1, &left) : hit;
        if (hit < 0) {
            settle(sim);
        }
    }
    return GB_DONE;
}
