#include "gb_lossy_gear.h"
#include "gb_constraint_forces.h"
#include "gb_constraint_state.h"
#include "gb_constraints.h"
#include "gb_loss.h"
#include "gb_rates.h"
#include "gb_report.h"
#include "gb_vector.h"

/* Most steps over the sides, and how many of them all at once without fewer that disagree; most combinations. */
enum { STEPS = 60, PATIENCE = 3, COMBINATIONS = 20000 };

/* Most combinations that are looked at for a second motion; accelerations are others where they differ by this part. */
enum { LOOKS = 729 };
static const double OTHER = 1e-6;

static const double *losses_of(const gb_sim *sim, int i) {
    return sim->constraints.bounds + 5 * i;
}

static int is_loss(const gb_sim *sim, int i) {
    return sim->model->constraints[i].kind == GB_LOSS;
}

int gb_has_lossy(const gb_sim *sim) {
    int found = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        found = found || is_loss(sim, i);
    }
    return found;
}

int gb_loss_is_upper(const gb_sim *sim, int i, const double *force) {
    const double *losses = losses_of(sim, i), tie = force[sim->model->constraints[i].partner];
    return force[i] - gb_loss_of(losses, -tie) > -gb_loss_of(losses, tie) - force[i];
}

/* The side that a gear which slides in a direction comes to from `side`, as its force crosses the limit of that. */
static int side_beyond(const double *losses, int side, double u) {
    if (side == 0) {
        return fabs(u + losses[1]) < fabs(u + losses[3]) ? 1 : -1;
    }
    return losses[1] < losses[3] ? 0 : -side;
}

/* The sides of the modes before, or those beyond a limit that has just been crossed (there either would do); those that
 * no mode tells follow from the forces before. */
static void begin(gb_sim *sim) {
    for (int i = 0; i < sim->model->n_constraints; i++) {
        const gb_constraint *loss = &sim->model->constraints[i];
        sim->lossy.base_decision[i] = sim->constraints.decision[i];
        sim->lossy.base_mode[i] = sim->mode[loss->slip];
        if (!is_loss(sim, i)) {
            continue;
        }
        const int sign = sim->model->constraints[loss->partner].slip;
        const double *losses = losses_of(sim, i), tie = sim->constraints.force_before[loss->partner];
        const double before = sim->constraints.mode_before[i];
        sim->lossy.forward[i] = gb_loss_side(losses, tie);
        sim->lossy.backward[i] = gb_loss_side(losses, -tie);
        if (before != 1.0 && before != -1.0) {
            continue;
        }
        int *side = before > 0.0 ? &sim->lossy.forward[i] : &sim->lossy.backward[i];
        const int present = (int)(before * sim->mode[sign]);
        if (sim->events.pending[sign] != 0.0) {
            *side = side_beyond(losses, present, before * tie);
        } else if (present != 0) {
            *side = present;
        }
    }
}

/* The active set with the sides that are assumed. */
static int solve(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_constraints; i++) {
        const gb_constraint *constraint = &model->constraints[i];
        sim->constraints.decision[i] = sim->lossy.base_decision[i];
        if (constraint->kind != GB_TIE) {
            sim->mode[constraint->slip] = sim->lossy.base_mode[i];
        }
    }
    for (int i = 0; i < model->n_constraints; i++) {
        const double direction = sim->lossy.base_mode[i];
        if (is_loss(sim, i) && sim->constraints.decision[i] != GB_CANDIDATE) {
            sim->mode[model->constraints[model->constraints[i].partner].slip] =
                direction * (direction > 0.0 ? sim->lossy.forward[i] : sim->lossy.backward[i]);
        }
    }
    return gb_choose_active_set(sim);
}

/* The force that the tie of gear i has come to lies on the side that was assumed, or beyond it by no more than
 * rounding; at rest the loss is in its range. */
static int holds_true(gb_sim *sim, int i) {
    const int j = sim->model->constraints[i].partner;
    const double *losses = losses_of(sim, i), tie = sim->constraints.force[j], force = sim->constraints.force[i];
    const double direction = sim->mode[sim->model->constraints[i].slip];
    const gb_delassus W = gb_delassus_of(sim);
    if (sim->constraints.decision[i] == GB_CANDIDATE) {
        const double excess = gb_loss_excess(losses, tie, force), response = fabs(gb_delassus_diagonal(&W, i));
        return gb_rests(sim, i) || excess <= 1e-10 * (fabs(force) + fabs(tie)) ||
               excess * response <= gb_acceleration_rounding(sim, i, 0.0);
    }
    double size;
    gb_slip_acceleration(sim, j, &size);
    const int side = direction > 0.0 ? sim->lossy.forward[i] : sim->lossy.backward[i];
    const double response = fabs(gb_delassus_diagonal(&W, j));
    return gb_loss_margin(losses, side, direction * tie) * response >= -gb_acceleration_rounding(sim, j, size);
}

/* Takes the sides of the forces found for gears that do not hold true, or for the first of them; returns how many. */
static int take_sides(gb_sim *sim, int all) {
    int wrong = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        if (is_loss(sim, i) && !holds_true(sim, i)) {
            const double tie = sim->constraints.force[sim->model->constraints[i].partner];
            if (all || wrong == 0) {
                sim->lossy.forward[i] = gb_loss_side(losses_of(sim, i), tie);
                sim->lossy.backward[i] = gb_loss_side(losses_of(sim, i), -tie);
            }
            wrong++;
        }
    }
    return wrong;
}

/* A failed try is none. */
static void forgive(gb_sim *sim) {
    sim->head->report.code = GB_DONE;
}

static void take_option(gb_sim *sim, int i, int option) {
    const int rests = sim->lossy.base_decision[i] == GB_CANDIDATE, slides = option == 0 ? 1 : option == 1 ? -1 : 0;
    int sides[2];
    gb_loss_option(option, sides);
    sim->lossy.option[i] = option;
    sim->lossy.forward[i] = rests ? sides[0] : slides;
    sim->lossy.backward[i] = rests ? sides[1] : slides;
}

/* The next combination of sides that can be; 0: there is none. */
static int next_combination(gb_sim *sim) {
    for (int i = 0; i < sim->model->n_constraints; i++) {
        if (!is_loss(sim, i)) {
            continue;
        }
        const double *losses = losses_of(sim, i);
        const int gap = losses[1] < losses[3], rests = sim->lossy.base_decision[i] == GB_CANDIDATE;
        const int count = rests ? gb_loss_options(losses) : (gap ? 3 : 2);
        take_option(sim, i, (sim->lossy.option[i] + 1) % count);
        if (sim->lossy.option[i] != 0) {
            return 1;
        }
    }
    return 0;
}

/* A gear that b cannot drive (eta2 < 0) and that turns. */
static int locks_while_it_slides(const gb_sim *sim, int i) {
    return losses_of(sim, i)[2] < -1.0 && sim->lossy.base_decision[i] == GB_SLIDES;
}

/* The first combination; returns the first gear that is self-locking and slides, or the last lossy gear. */
static int first_combination(gb_sim *sim) {
    int last = 0, locking = -1;
    for (int i = sim->model->n_constraints - 1; i >= 0; i--) {
        if (is_loss(sim, i)) {
            take_option(sim, i, 0);
            last = i > last ? i : last;
            locking = locks_while_it_slides(sim, i) ? i : locking;
        }
    }
    return locking >= 0 ? locking : last;
}

/* A gear whose tie, or what rubs in it, shares its load with another lock, if none locks itself; or -1. */
static int shares_its_load(const gb_sim *sim) {
    int found = -1;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        if (is_loss(sim, i) && locks_while_it_slides(sim, i)) {
            return -1;
        }
        const int shares = is_loss(sim, i) && (sim->constraints.was_redundant[i] ||
                                               sim->constraints.was_redundant[sim->model->constraints[i].partner]);
        found = shares ? i : found;
    }
    return found;
}

/* The sides that are assumed now are those of a motion. */
static int is_a_motion(gb_sim *sim) {
    int holds = solve(sim) == GB_DONE;
    forgive(sim);
    for (int i = 0; i < sim->model->n_constraints && holds; i++) {
        holds = !is_loss(sim, i) || holds_true(sim, i);
    }
    return holds;
}

static int try_every_combination(gb_sim *sim) {
    const int culprit = first_combination(sim);
    for (int count = 0; count < COMBINATIONS; count++) {
        if (is_a_motion(sim)) {
            return GB_DONE;
        }
        if (!next_combination(sim)) {
            break;
        }
    }
    const int shares = shares_its_load(sim), named = shares >= 0 ? shares : culprit;
    return gb_fail(sim, GB_ERR_LOSS, sim->model->constraints[named].slip, sim->head->front.t1, shares >= 0 ? 3.0 : 0.0);
}

/* The sides now assumed give other accelerations of lossy gears than those in `rate`. */
static int is_another(gb_sim *sim, const double *rate) {
    for (int i = 0; i < sim->model->n_constraints; i++) {
        double size;
        const double now = gb_slip_acceleration(sim, i, &size), before = rate[i];
        if (is_loss(sim, i) &&
            fabs(now - before) > OTHER * (fabs(now) + fabs(before)) + gb_acceleration_rounding(sim, i, size)) {
            return 1;
        }
    }
    return 0;
}

/* The motion found is the only one. */
static int refuse_a_second(gb_sim *sim) {
    const int n = sim->model->n_constraints;
    double rate[n + 1], size;
    int forward[n + 1], backward[n + 1], locking = 0;
    for (int i = 0; i < n; i++) {
        locking = locking || (is_loss(sim, i) && locks_while_it_slides(sim, i));
        rate[i] = gb_slip_acceleration(sim, i, &size);
        forward[i] = sim->lossy.forward[i];
        backward[i] = sim->lossy.backward[i];
    }
    if (!locking) {
        return GB_DONE;
    }
    const int culprit = first_combination(sim);
    for (int count = 0; count < LOOKS; count++) {
        if (is_a_motion(sim) && is_another(sim, rate)) {
            return gb_fail(sim, GB_ERR_LOSS, sim->model->constraints[culprit].slip, sim->head->front.t1, 2.0);
        }
        if (!next_combination(sim)) {
            break;
        }
    }
    memcpy(sim->lossy.forward, forward, sizeof(int) * (size_t)n);
    memcpy(sim->lossy.backward, backward, sizeof(int) * (size_t)n);
    return solve(sim);
}

/* As gb_choose_lossy, whatever other motions there are. */
static int choose(gb_sim *sim) {
    int fewest = sim->model->n_constraints + 1, patience = PATIENCE;
    begin(sim);
    for (int step = 0; step < STEPS; step++) {
        if (solve(sim) != GB_DONE) {
            forgive(sim);
            break;
        }
        const int wrong = take_sides(sim, patience > 0);
        if (wrong == 0) {
            return GB_DONE;
        }
        patience = wrong < fewest ? PATIENCE : patience - 1;
        fewest = wrong < fewest ? wrong : fewest;
    }
    return try_every_combination(sim);
}

int gb_choose_lossy(gb_sim *sim, int starting) {
    const int code = choose(sim);
    return code == GB_DONE && starting ? refuse_a_second(sim) : code;
}
