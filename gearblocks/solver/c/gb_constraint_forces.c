#include "gb_constraint_forces.h"
#include "gb_constraint_state.h"
#include "gb_constraints.h"
#include "gb_force_split.h"
#include "gb_loss.h"
#include "gb_rates.h"
#include "gb_report.h"
#include "gb_vector.h"

void gb_free_rates(gb_sim *sim, const double *time_terms, const double *y, double *rates) {
    const gb_model *model = sim->model;
    double *mode = sim->sliding.mode;
    memcpy(mode, sim->mode, sizeof(double) * sim->unlocated.n_carried);
    for (int i = 0; i < model->n_constraints; i++) {
        mode[model->constraints[i].active] = 0.0;
    }
    mode[model->n_switches] = 0.0;
    model->rhs(sim->par, mode, time_terms, y, rates);
    sim->head->counts.rhs_calls++;
}

/* Free slip accelerations: with the present modes and no constraint active. */
static int free_accelerations(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_constraints; i++) {
        sim->mode[model->constraints[i].active] = 0.0;
    }
    sim->mode[model->n_switches] = 0.0;
    model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->constraints.y, sim->z2);
    sim->head->counts.rhs_calls++;
    const int code = gb_check_finite(sim, GB_ERR_NAN_RATE, sim->z2, model->n, 0, sim->head->front.t1);
    if (code == GB_DONE) {
        model->slips(sim->par, sim->mode, sim->instant.time_terms, sim->constraints.y, sim->z2,
                     sim->constraints.free_acceleration);
        gb_forget_underflow(sim->constraints.free_acceleration, model->n_constraints);
        sim->constraints.fastest = 0.0;
        for (int k = model->n - model->n_speeds; k < model->n; k++) {
            sim->constraints.fastest = gb_max(sim->constraints.fastest, fabs(sim->z2[k]));
        }
    }
    return code;
}

/* What rounds the accelerations that slips are made of. */
static double rounding_of_rates(const gb_sim *sim) {
    return 256.0 * DBL_EPSILON * sim->constraints.fastest;
}

double gb_acceleration_rounding(const gb_sim *sim, int i, double size) {
    return gb_max(1e-10 * size, rounding_of_rates(sim) * sim->constraints.row_size[i]);
}

/* No force of constraint i changes its slip, which grows all the same: time prescribes the motion of both sides. */
static int cannot_hold(const gb_sim *sim, int i) {
    const gb_delassus W = gb_delassus_of(sim);
    return sim->model->constraints[i].kind == GB_FRICTION && !(gb_delassus_diagonal(&W, i) > 0.0) &&
           sim->constraints.free_acceleration[i] != 0.0;
}

/* Bounds of the constraint force of candidate i: what it holds while stuck, and once it is broken what it carries while
 * it slides. Those of a lossy gear at rest grow with the force of its tie, along the sides that are assumed. */
static void bounds_of(gb_sim *sim, int i) {
    struct gb_constraints *c = &sim->constraints;
    const double *bounds = c->bounds + 5 * i, keep = 1.0 - c->shrink[i];
    const int broken = c->broken[i];
    c->on[i] = -1;
    if (gb_rests(sim, i)) {
        c->lo[i] = -HUGE_VAL;
        c->hi[i] = HUGE_VAL;
        return;
    }
    if (sim->model->constraints[i].kind == GB_LOSS) {
        const gb_loss_line forward = gb_loss_on_side(bounds, sim->lossy.forward[i]),
                           backward = gb_loss_on_side(bounds, sim->lossy.backward[i]);
        c->on[i] = sim->model->constraints[i].partner;
        c->lo[i] = -keep * forward.fixed;
        c->hi[i] = keep * backward.fixed;
        c->lo_slope[i] = -keep * forward.slope;
        c->hi_slope[i] = -keep * backward.slope;
        return;
    }
    c->lo[i] = bounds[0] <= -HUGE_VAL ? -HUGE_VAL : broken ? gb_max(bounds[0], -bounds[2]) : keep * bounds[0];
    c->hi[i] = bounds[1] >= HUGE_VAL ? HUGE_VAL : broken ? gb_min(bounds[1], bounds[3]) : keep * bounds[1];
    c->hi[i] = gb_max(c->hi[i], c->lo[i]);
}

/* A candidate slides from here, with this slip acceleration. */
static void slide(gb_sim *sim, int i, double w) {
    const gb_constraint *constraint = &sim->model->constraints[i];
    const double direction = w > 0.0 ? 1.0 : -1.0;
    sim->constraints.decision[i] = constraint->kind == GB_STOP ? GB_IS_OPEN : GB_SLIDES;
    sim->mode[constraint->slip] = constraint->kind == GB_STOP ? 0.0 : direction;
    if (constraint->kind == GB_LOSS) {
        const int *side = direction > 0.0 ? sim->lossy.forward : sim->lossy.backward;
        sim->mode[sim->model->constraints[constraint->partner].slip] = direction * side[i];
    }
}

/* The complementarity problem of the candidates with the bounds that they have now, of which those of static peaks may
 * be left out; bounds that grow with a force are those at the solution afterwards. */
static int solve_within(gb_sim *sim, int without_peaks) {
    struct gb_constraints *c = &sim->constraints;
    const int n = sim->model->n_constraints;
    int coupled = 0;
    for (int i = 0; i < n; i++) {
        if (c->in[i]) {
            bounds_of(sim, i);
            coupled = coupled || (c->on[i] >= 0 && c->in[c->on[i]]);
            if (without_peaks && c->peak[i] > 0.0) {
                c->lo[i] = -HUGE_VAL;
                c->hi[i] = HUGE_VAL;
            }
        }
    }
    const gb_coupled_bounds growth = {c->on, c->lo_slope, c->hi_slope, 0};
    const int code = gb_solve_problem(sim, coupled);
    for (int i = 0; i < n && coupled && code == GB_DONE; i++) {
        if (c->in[i]) {
            c->lo[i] += gb_lcp_shift(&growth, i, -1, c->force);
            c->hi[i] += gb_lcp_shift(&growth, i, 1, c->force);
        }
    }
    return code;
}

/* Slip acceleration of candidate i; 0 where it is rounding, or no force is at its bound. */
static double candidate_slip(const gb_sim *sim, int i) {
    const struct gb_constraints *c = &sim->constraints;
    if (c->force[i] > c->lo[i] && c->force[i] < c->hi[i]) {
        return 0.0;
    }
    double size;
    const double w = gb_slip_acceleration(sim, i, &size);
    return fabs(w) > gb_acceleration_rounding(sim, i, size) ? w : 0.0;
}

/* What candidate i carried before: its force while stuck, what slips against its slip. */
static double force_before(const gb_sim *sim, int i) {
    const double mode = sim->constraints.mode_before[i], *bounds = sim->constraints.bounds + 5 * i;
    return mode == 0.0 ? sim->constraints.force_before[i] : mode == 1.0 ? -bounds[2] : mode == -1.0 ? bounds[3] : 0.0;
}

/* How far candidate i, which a force holds that is more than its peak, is beyond it, in parts of the way to the peak
 * from what it carried before. */
static double beyond_peak(const gb_sim *sim, int i, double peak) {
    const double held = sim->constraints.force[i], before = force_before(sim, i);
    const double room = copysign(peak, held) - before;
    return room * held > 0.0 ? (held - before) / room : HUGE_VAL;
}

/* Among `over` candidates that slip beyond their static peaks those break that come to their peak first as all forces
 * go from what they were to what would hold: where a slip ends, the force of its friction turns around, and takes those
 * of others along. Of one alone nothing has to be asked, and held without limit beside a lossy gear it may leave no
 * forces, or many. */
static int break_first(gb_sim *sim, int over) {
    struct gb_constraints *c = &sim->constraints;
    const int n = sim->model->n_constraints, code = over > 1 ? solve_within(sim, 1) : GB_DONE;
    double most = 0.0;
    for (int i = 0; i < n && code == GB_DONE; i++) {
        c->peak[i] = c->in[i] && c->peak[i] > 0.0 ? beyond_peak(sim, i, c->peak[i]) : 0.0;
        most = gb_max(most, c->peak[i]);
    }
    for (int i = 0; i < n; i++) {
        if (c->in[i] && c->peak[i] > 0.0 && c->peak[i] >= (1.0 - 1e-9) * most) {
            c->broken[i] = 1;
        }
    }
    return code;
}

/* The complementarity problem of the candidates. A candidate that slips although it holds its static peak is broken: it
 * goes on with what it carries while it slides, and may stay at rest with no more than that. */
static int break_in_turn(gb_sim *sim) {
    const int n = sim->model->n_constraints;
    int code = GB_DONE;
    for (int over = 1, round = 0; over > 0 && code == GB_DONE && round <= n; round++) {
        code = solve_within(sim, 0);
        over = 0;
        for (int i = 0; i < n && code == GB_DONE; i++) {
            const double w = sim->constraints.in[i] ? candidate_slip(sim, i) : 0.0;
            const double *bounds = sim->constraints.bounds + 5 * i;
            const double force = fabs(sim->constraints.force[i]), sliding = w > 0.0 ? bounds[2] : bounds[3];
            const int drops = sim->model->constraints[i].kind == GB_FRICTION && sliding < (1.0 - 1e-12) * force;
            sim->constraints.peak[i] = w != 0.0 && drops && !sim->constraints.broken[i] ? force : 0.0;
            over += sim->constraints.peak[i] > 0.0;
        }
        if (over > 0) {
            code = break_first(sim, over);
        }
    }
    return code;
}

/* Where friction passes a slip of zero, whatever the others do, its peak lasts for no time: what was at rest and broke
 * by it is whole again. Returns how many. */
static int mend_what_passing_broke(gb_sim *sim) {
    struct gb_constraints *c = &sim->constraints;
    int passes = 0, mended = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        passes = passes || (c->in[i] && fabs(c->mode_before[i]) == 1.0 && candidate_slip(sim, i) != 0.0);
    }
    for (int i = 0; i < sim->model->n_constraints && passes; i++) {
        if (c->in[i] && c->mode_before[i] == 0.0 && c->broken[i] && !c->was_broken[i]) {
            c->broken[i] = 0;
            mended++;
        }
    }
    return mended;
}

static int solve_with_peaks(gb_sim *sim) {
    const int code = break_in_turn(sim);
    return code == GB_DONE && mend_what_passing_broke(sim) > 0 ? break_in_turn(sim) : code;
}

/* The bounds of all candidates before any of them broke, in lo and hi; tie_of: ties of the losses among them. Returns
 * how many these are. */
static int bounds_before(gb_sim *sim, int *tie_of) {
    struct gb_constraints *c = &sim->constraints;
    int gears = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        const int lossy = sim->model->constraints[i].kind == GB_LOSS && !gb_rests(sim, i);
        tie_of[i] = c->in[i] && lossy ? sim->model->constraints[i].partner : -1;
        gears += tie_of[i] >= 0;
        if (c->in[i] && tie_of[i] < 0) {
            const int now = c->broken[i];
            c->broken[i] = c->was_broken[i];
            bounds_of(sim, i);
            c->broken[i] = now;
        }
    }
    return gears;
}

/* Slip accelerations of the candidates. A gear at rest that shares its load may hold it by more force on its tie than
 * the complementarity problem has found: what can rest does, beside what slips in any case. */
static void slips_of_candidates(gb_sim *sim, double *slip) {
    struct gb_constraints *c = &sim->constraints;
    const int n = sim->model->n_constraints;
    int tie_of[n + 1], slips = 0, with = 0, alone = 0;
    double force[n + 1], rest[n + 1], size;
    for (int i = 0; i < n; i++) {
        slip[i] = c->in[i] ? candidate_slip(sim, i) : 0.0;
        slips += slip[i] != 0.0;
    }
    if (slips == 0 || bounds_before(sim, tie_of) == 0) {
        return;
    }
    const gb_lcp problem = {gb_delassus_of(sim), c->in, NULL, c->room, 0, NULL};
    const gb_force_bounds bounds = {c->lo, c->hi, c->bounds, tie_of, c->shrink};
    memcpy(force, c->force, sizeof(double) * (size_t)n);
    gb_split_at_rest(&problem, c->right, &bounds, c->force);
    for (int i = 0; i < n; i++) {
        const double w = c->in[i] ? gb_slip_acceleration(sim, i, &size) : 0.0;
        rest[i] = c->in[i] && fabs(w) > gb_acceleration_rounding(sim, i, size) ? w : 0.0;
        with += rest[i] != 0.0 && slip[i] != 0.0;
        alone += rest[i] != 0.0 && slip[i] == 0.0;
    }
    for (int i = 0; i < n; i++) {
        c->force[i] = alone == 0 ? c->force[i] : force[i];
        c->broken[i] = alone + with == 0 ? c->was_broken[i] : c->broken[i];
        slip[i] = alone == 0 && rest[i] == 0.0 ? 0.0 : slip[i];
    }
}

/* The candidates whose slip no force within their bounds keeps at zero slide from here; returns how many. */
static int decide(gb_sim *sim, int *code) {
    const gb_model *model = sim->model;
    struct gb_constraints *c = &sim->constraints;
    const int n = model->n_constraints;
    double slip[n + 1];
    int lost = 0;
    for (int i = 0; i < n; i++) {
        if (c->decision[i] == GB_CANDIDATE && cannot_hold(sim, i)) {
            c->decision[i] = GB_SLIDES;
            sim->mode[model->constraints[i].slip] = c->free_acceleration[i] > 0.0 ? 1.0 : -1.0;
            lost++;
        }
        c->in[i] = c->decision[i] == GB_CANDIDATE;
        c->right[i] = c->free_acceleration[i];
    }
    *code = solve_with_peaks(sim);
    if (*code == GB_DONE) {
        slips_of_candidates(sim, slip);
    }
    for (int i = 0; i < n && *code == GB_DONE; i++) {
        if (slip[i] != 0.0) {
            slide(sim, i, slip[i]);
            c->shrink[i] = 0.0;
            lost++;
        }
    }
    if (*code == GB_DONE && lost == 0) {
        *code = gb_refuse_contradiction(sim, rounding_of_rates(sim));
    }
    if (*code != GB_DONE) {
        memset(c->force, 0, sizeof(double) * (size_t)n);
    }
    return *code == GB_DONE ? lost : 0;
}

/* What was released at its peak and would slide back at once, since another one let go too, stays at rest with what it
 * carries while it slides; returns how many. */
static int take_back(gb_sim *sim) {
    int back = 0;
    for (int i = 0; i < sim->model->n_constraints; i++) {
        const gb_constraint *constraint = &sim->model->constraints[i];
        if (constraint->kind == GB_FRICTION && sim->constraints.released[i] && !sim->constraints.broken[i] &&
            sim->constraints.decision[i] == GB_SLIDES) {
            double size;
            const double rate = gb_slip_acceleration(sim, i, &size);
            if (sim->mode[constraint->slip] * rate < -1e-6 * size) {
                sim->constraints.decision[i] = GB_CANDIDATE;
                sim->constraints.broken[i] = 1;
                sim->mode[constraint->slip] = 0.0;
                back++;
            }
        }
    }
    return back;
}

int gb_choose_active_set(gb_sim *sim) {
    const int n = sim->model->n_constraints;
    int code = GB_DONE;
    for (int i = 0; i < n; i++) {
        sim->constraints.broken[i] = sim->constraints.was_broken[i];
    }
    for (int round = 0; code == GB_DONE && round <= 2 * n; round++) {
        code = free_accelerations(sim);
        if (code == GB_DONE) {
            sim->model->delassus(sim->par, sim->mode, sim->instant.time_terms, sim->constraints.y, 1,
                                 sim->constraints.delassus);
            if (decide(sim, &code) == 0 && (code != GB_DONE || take_back(sim) == 0)) {
                break;
            }
        }
    }
    return code;
}

double gb_slip_acceleration(const gb_sim *sim, int i, double *size) {
    const gb_delassus W = gb_delassus_of(sim);
    const double rate = sim->constraints.free_acceleration[i];
    *size = fabs(rate);
    return rate + gb_delassus_product(&W, i, sim->constraints.force, size);
}
