#include "gb_impact.h"
#include "gb_constraint_state.h"
#include "gb_limit_noise.h"
#include "gb_modes.h"
#include "gb_report.h"
#include "gb_tolerance.h"
#include "gb_vector.h"

/* Rounds of an impact; and those in which a stop was left out because it is being left, before they have no end. */
enum { ROUNDS = 10000, LEAVING_ROUNDS = 32 };

/* Squares of restitutions beyond which impacts do not end a cascade by themselves. */
static const double MOST_KEPT = 0.999;

/* Impacts on a stop from which on they are low where their energy is. */
static const double MANY = 1e5;

/* A flight of such a duration and height cannot be told from rest: its end lies within the rounding of time, or is
 * located no better than the rounding of the gap and would give back the speed that the impact took. Where the search
 * told the gap less finely, each flight ends as much lower, and impacts that lose little keep what that gives. */
static int is_nothing(gb_sim *sim, int i, double duration, double height, double restitution) {
    const gb_head *head = sim->head;
    const int gap = sim->model->constraints[i].slip;
    const double kept = gb_min(restitution * restitution, MOST_KEPT), noise = sim->panel.noise[gap];
    return duration <= 64.0 * gb_rounding(head->front.t1, head->front.h) || height <= 2.0 * noise / (1.0 - kept) ||
           gb_is_noise(sim, gap, height, sim->instant.time_terms, sim->y, sim->y);
}

/* Flights from a stop that takes next to nothing have no end where the motion between them loses energy, or the load
 * grows: they become lower and as many more. Such a speed and height are less than what the tolerance admits of both
 * sides of the stop: the run cannot tell them from rest, nor in which of the flights it is. After N of them it cannot
 * tell the latter of N times that speed either, and takes rest where their energy is less than the tolerance too. */
static int cannot_be_told(gb_sim *sim, int i, double speed, double height, double restitution) {
    const double impacts = sim->constraints.impacts[i], slow = gb_min(impacts, 1.0 / sqrt(sim->head->options.rtol));
    return restitution * restitution > MOST_KEPT &&
           speed <= (impacts < MANY ? 1.0 : slow) * gb_tolerance_of_slip(sim, i) &&
           height <= gb_tolerance_of(sim, sim->model->constraints[i].slip);
}

/* The restitution of stop i. It comes to rest where what presses it brings it back from nothing but such a flight; how
 * long the last flight was does not tell, it may have been the first or have ended at a body that came its way. */
static double restitution(gb_sim *sim, int i) {
    const gb_model *model = sim->model;
    const double given = sim->constraints.bounds[5 * i + 2], speed = given * fabs(sim->constraints.slip[i]);
    double *rate = sim->constraints.free_acceleration;
    if (!(given > 0.0)) {
        return given;
    }
    model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->y, sim->z2);
    sim->head->counts.rhs_calls++;
    model->slips(sim->par, sim->mode, sim->instant.time_terms, sim->y, sim->z2, rate);
    const double push = -rate[i], height = 0.5 * speed * speed / push;
    const int rests = push > 0.0 && (is_nothing(sim, i, 2.0 * speed / push, height, given) ||
                                     cannot_be_told(sim, i, speed, height, given));
    return rests ? 0.0 : given;
}

int gb_opens_for_nothing(gb_sim *sim, int i) {
    const gb_delassus W = gb_delassus_of(sim);
    const double slip = sim->constraints.slip[i], push = sim->constraints.force_before[i] * gb_delassus_diagonal(&W, i);
    return gb_is_active(sim, i) && push > 0.0 &&
           is_nothing(sim, i, 2.0 * slip / push, 0.5 * slip * slip / push, sim->constraints.bounds[5 * i + 2]);
}

/* A body at stop i, at rest and open, is pulled away from it: whatever strikes the body an instant later finds it
 * apart, and drives it back onto the stop in an impact of its own. Where a run begins nothing has been left. */
static int is_being_left(gb_sim *sim, int i) {
    const gb_model *model = sim->model;
    const double slip = sim->constraints.slip[i];
    double *rate = sim->constraints.free_acceleration, largest = 0.0;
    if (!gb_is_stop(sim, i) || gb_is_active(sim, i) || fabs(slip) > sim->constraints.slip_rounding[i] ||
        (sim->events.pending[model->constraints[i].slip] != 0.0 && !sim->constraints.struck[i]) ||
        !(sim->head->front.t1 > sim->head->front.t_start)) {
        return 0;
    }
    model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->y, sim->z2);
    sim->head->counts.rhs_calls++;
    model->slips(sim->par, sim->mode, sim->instant.time_terms, sim->y, sim->z2, rate);
    for (int j = model->n - model->n_speeds; j < model->n; j++) {
        largest = gb_max(largest, fabs(sim->z2[j]));
    }
    return rate[i] > 1e-9 * largest * sim->constraints.row_size[i];
}

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
        *undo = strikes ? slip * (1.0 + restitution(sim, i)) : slip;
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
    sim->constraints.impacts[i] += 1.0;
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

/* Slips after an impact. Their rounding is that of the speeds that it took: where all bodies come to rest at once, what
 * is left of the speeds is nothing but that, and would tell directions of sliding. */
static void slips_after(gb_sim *sim) {
    const double speed = sim->constraints.slip_rounding[0] / sim->constraints.row_size[0];
    gb_slips_now(sim);
    for (int i = 0; i < sim->model->n_constraints; i++) {
        sim->constraints.slip_rounding[i] =
            gb_max(sim->constraints.slip_rounding[i], speed * sim->constraints.row_size[i]);
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
        if (gb_is_stop(sim, i) || gb_is_unbounded(sim, i) || !gb_is_active(sim, i)) {
            note_impact(sim, i, impulse[i], before[i], sim->constraints.slip[i]);
        }
        const double earlier = sim->constraints.struck[i] ? sim->constraints.slip_before[i] : 0.0;
        sim->constraints.slip_before[i] = gb_max(earlier, fabs(before[i]));
        sim->constraints.struck[i] = 1;
    }
}

/* Takes the stops that are being left out of the round. */
static void leave_out(gb_sim *sim, int *left) {
    int any = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        if (sim->constraints.in[i] && is_being_left(sim, i)) {
            sim->constraints.in[i] = 0;
            any = 1;
        }
    }
    *left += any;
}

/* What takes part where flights on a stop end as the slip of a lock does: each would throw the other off by a part of
 * what is left, in a cascade of both that nothing is seen of. They come to rest as one. */
static void end_together(gb_sim *sim) {
    double *b = sim->constraints.right;
    int ends = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        const double slip = sim->constraints.slip[i];
        ends |= sim->constraints.in[i] && gb_is_stop(sim, i) && sim->constraints.bounds[5 * i + 2] > 0.0 &&
                slip < -sim->constraints.slip_rounding[i] && b[i] == slip;
    }
    for (int i = 0; i < sim->model->n_constraints && ends; i++) {
        if (!sim->constraints.in[i] && ends_slip(sim, i)) {
            sim->constraints.in[i] = 1;
            sim->constraints.lo[i] = -HUGE_VAL;
            sim->constraints.hi[i] = HUGE_VAL;
            b[i] = sim->constraints.slip[i];
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
        end_together(sim);
    }
    return hit;
}

/* The impulses of a round that is set up, into constraints.other; slips before it are in free_acceleration. */
static int strike(gb_sim *sim) {
    const size_t size = sizeof(double) * (size_t)sim->model->n_constraints;
    sim->model->delassus(sim->par, sim->mode, sim->instant.time_terms, sim->y, 0, sim->constraints.delassus);
    if (gb_solve_problem(sim, 0) != GB_DONE || gb_refuse_contradiction(sim) != GB_DONE) {
        return sim->head->report.code;
    }
    memcpy(sim->constraints.other, sim->constraints.force, size);
    memcpy(sim->constraints.free_acceleration, sim->constraints.slip, size);
    apply_impulses(sim, sim->constraints.other);
    slips_after(sim);
    return GB_DONE;
}

/* What an impact elsewhere opens for nothing stays closed: the bodies share their momentum, as they do in a flight that
 * ends at once. No event. any: whether there was such a contact; what it drives back is struck again. */
static int close_what_opens_for_nothing(gb_sim *sim, int *any) {
    double *b = sim->constraints.right, *lo = sim->constraints.lo, *hi = sim->constraints.hi;
    *any = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        sim->constraints.in[i] = takes_impulse(sim, i, 1, &lo[i], &hi[i], &b[i]);
        if (gb_is_stop(sim, i) && sim->constraints.slip[i] > sim->constraints.slip_rounding[i] && gb_touches(sim, i) &&
            gb_opens_for_nothing(sim, i)) {
            sim->constraints.in[i] = *any = 1;
            lo[i] = -HUGE_VAL;
            hi[i] = HUGE_VAL;
            b[i] = sim->constraints.slip[i];
        }
    }
    if (!*any || strike(sim) != GB_DONE) {
        return *any ? sim->head->report.code : GB_DONE;
    }
    for (int i = 0; i < sim->model->n_constraints; i++) {
        const double mean = 0.5 * (sim->constraints.free_acceleration[i] + sim->constraints.slip[i]);
        note_loss(sim, i, -sim->constraints.other[i] * mean);
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
        if (round == ROUNDS) {
            return gb_fail(sim, GB_ERR_CHATTER, model->constraints[hit].slip, sim->head->front.t1, 0.0);
        }
        sim->head->control.h_trusted = 0.0; /* what comes is another motion: no step of it has been looked into */
        if (strike(sim) != GB_DONE) {
            return sim->head->report.code;
        }
        note_round(sim, impulse, before);
        hit = find_hit(sim, round + 1, &left);
        if (hit < 0 && close_what_opens_for_nothing(sim, &closed) != GB_DONE) {
            return sim->head->report.code;
        }
        hit = closed ? find_hit(sim, round + 1, &left) : hit;
    }
    return GB_DONE;
}
