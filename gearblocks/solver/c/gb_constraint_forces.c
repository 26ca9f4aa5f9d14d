#include "gb_constraint_forces.h"
#include "gb_constraint_rows.h"
#include "gb_constraint_state.h"
#include "gb_constraints.h"
#include "gb_report.h"
#include "gb_vector.h"

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
        sim->constraints.fastest = 0.0;
        for (int k = model->n - model->n_speeds; k < model->n; k++) {
            sim->constraints.fastest = gb_max(sim->constraints.fastest, fabs(sim->z2[k]));
        }
    }
    return code;
}

double gb_acceleration_rounding(const gb_sim *sim, int i, double size) {
    return gb_max(1e-10 * size, 256.0 * DBL_EPSILON * sim->constraints.row_size[i] * sim->constraints.fastest);
}

/* No force of constraint i changes its slip, which grows all the same: time prescribes the motion of both sides. */
static int cannot_hold(const gb_sim *sim, int i) {
    const double own = sim->constraints.delassus[i * sim->model->n_constraints + i];
    return sim->model->constraints[i].kind == GB_FRICTION && !(own > 0.0) &&
           sim->constraints.free_acceleration[i] != 0.0;
}

/* Bounds of the constraint force of candidate number p, constraint i: what it holds while stuck, and once it is broken
 * what it carries while it slides. Those of a lossy gear at rest grow with the force of its tie, along the sides that
 * are assumed. */
static void bounds_of(gb_sim *sim, int i, int p) {
    struct gb_constraints *c = &sim->constraints;
    const double *bounds = c->bounds + 5 * i, keep = 1.0 - c->shrink[i];
    const int broken = c->broken[i];
    c->on[p] = -1;
    if (sim->model->constraints[i].kind == GB_LOSS) {
        const gb_loss_line forward = gb_loss_on_side(bounds, sim->lossy.forward[i]),
                           backward = gb_loss_on_side(bounds, sim->lossy.backward[i]);
        c->on[p] = sim->model->constraints[i].partner;
        c->lo[p] = -keep * forward.fixed;
        c->hi[p] = keep * backward.fixed;
        c->lo_slope[p] = -keep * forward.slope;
        c->hi_slope[p] = -keep * backward.slope;
        return;
    }
    c->lo[p] = bounds[0] <= -HUGE_VAL ? -HUGE_VAL : broken ? gb_max(bounds[0], -bounds[2]) : keep * bounds[0];
    c->hi[p] = bounds[1] >= HUGE_VAL ? HUGE_VAL : broken ? gb_min(bounds[1], bounds[3]) : keep * bounds[1];
    c->hi[p] = gb_max(c->hi[p], c->lo[p]);
}

/* Ties have numbers among the candidates. Returns whether there are any that bounds grow with. */
static int number_ties(gb_sim *sim, int count) {
    int found = 0;
    for (int i = 0; i < count; i++) {
        for (int j = 0, tie = sim->constraints.on[i]; tie >= 0 && j < count; j++) {
            if (sim->constraints.index[j] == tie) {
                sim->constraints.on[i] = j;
                found = 1;
            }
        }
    }
    return found;
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

/* The complementarity problem of `count` candidates with the bounds that they have now, of which those of static peaks
 * may be left out; bounds that grow with a force are those at the solution afterwards. */
static int solve_within(gb_sim *sim, int count, int without_peaks) {
    struct gb_constraints *c = &sim->constraints;
    for (int p = 0; p < count; p++) {
        bounds_of(sim, c->index[p], p);
        if (without_peaks && c->peak[p] > 0.0) {
            c->lo[p] = -HUGE_VAL;
            c->hi[p] = HUGE_VAL;
        }
    }
    const int coupled = number_ties(sim, count);
    const gb_coupled_bounds growth = {c->on, c->lo_slope, c->hi_slope};
    const int code = gb_solve_problem(sim, count, coupled);
    for (int p = 0; p < count && coupled && code == GB_DONE; p++) {
        c->lo[p] += gb_lcp_shift(&growth, p, -1, c->force);
        c->hi[p] += gb_lcp_shift(&growth, p, 1, c->force);
    }
    return code;
}

/* Slip acceleration of the p-th of `count` candidates; 0 where it is rounding, or no force is at its bound. */
static double candidate_slips(const gb_sim *sim, int p, int count) {
    const double *x = sim->constraints.force;
    double w = sim->constraints.right[p], size = fabs(w);
    for (int q = 0; q < count; q++) {
        w += sim->constraints.matrix[p * count + q] * x[q];
        size += fabs(sim->constraints.matrix[p * count + q] * x[q]);
    }
    const int at_bound = x[p] <= sim->constraints.lo[p] || x[p] >= sim->constraints.hi[p];
    return at_bound && fabs(w) > gb_acceleration_rounding(sim, sim->constraints.index[p], size) ? w : 0.0;
}

/* Among the candidates that slip beyond their static peaks those break that the load exceeds most, in proportion to
 * the peak: they would be the first if it rose from zero. */
static int break_first(gb_sim *sim, int count) {
    const double *x = sim->constraints.force;
    double *peak = sim->constraints.peak, most = 0.0;
    const int code = solve_within(sim, count, 1);
    for (int p = 0; p < count && code == GB_DONE; p++) {
        peak[p] = peak[p] > 0.0 ? fabs(x[p]) / peak[p] : 0.0;
        most = gb_max(most, peak[p]);
    }
    for (int p = 0; p < count; p++) {
        if (peak[p] > 0.0 && peak[p] >= (1.0 - 1e-9) * most) {
            sim->constraints.broken[sim->constraints.index[p]] = 1;
        }
    }
    return code;
}

/* The complementarity problem of `count` candidates. A candidate that slips although it holds its static peak is
 * broken: it goes on with what it carries while it slides, and may stay at rest with no more than that. */
static int solve_with_peaks(gb_sim *sim, int count) {
    int code = GB_DONE;
    for (int over = 1, round = 0; over > 0 && code == GB_DONE && round <= count; round++) {
        code = solve_within(sim, count, 0);
        over = 0;
        for (int p = 0; p < count && code == GB_DONE; p++) {
            const int i = sim->constraints.index[p];
            const double w = candidate_slips(sim, p, count), *bounds = sim->constraints.bounds + 5 * i;
            const double force = fabs(sim->constraints.force[p]), sliding = w > 0.0 ? bounds[2] : bounds[3];
            const int drops = sim->model->constraints[i].kind == GB_FRICTION && sliding < (1.0 - 1e-12) * force;
            sim->constraints.peak[p] = w != 0.0 && drops && !sim->constraints.broken[i] ? force : 0.0;
            over += sim->constraints.peak[p] > 0.0;
        }
        if (over > 0) {
            code = break_first(sim, count);
        }
    }
    return code;
}

/* The candidates whose slip no force within their bounds keeps at zero slide from here; returns how many. */
static int decide(gb_sim *sim, int *code) {
    const gb_model *model = sim->model;
    const int n = model->n_constraints;
    int *index = sim->constraints.index, count = 0, lost = 0;
    for (int i = 0; i < n; i++) {
        if (sim->constraints.decision[i] == GB_CANDIDATE && cannot_hold(sim, i)) {
            sim->constraints.decision[i] = GB_SLIDES;
            sim->mode[model->constraints[i].slip] = sim->constraints.free_acceleration[i] > 0.0 ? 1.0 : -1.0;
            lost++;
        }
        if (sim->constraints.decision[i] == GB_CANDIDATE) {
            sim->constraints.right[count] = sim->constraints.free_acceleration[i];
            index[count++] = i;
        }
    }
    *code = solve_with_peaks(sim, count);
    for (int p = 0; p < count && *code == GB_DONE; p++) {
        const double w = candidate_slips(sim, p, count);
        if (w != 0.0) {
            slide(sim, index[p], w);
            sim->constraints.shrink[index[p]] = 0.0;
            lost++;
        }
    }
    if (*code == GB_DONE && lost == 0) {
        *code = gb_refuse_contradiction(sim, count);
    }
    sim->constraints.count = *code == GB_DONE ? count : 0;
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

double gb_constraint_force(const gb_sim *sim, int i) {
    for (int j = 0; j < sim->constraints.count; j++) {
        if (sim->constraints.index[j] == i) {
            return sim->constraints.force[j];
        }
    }
    return 0.0;
}

double gb_slip_acceleration(const gb_sim *sim, int i, double *size) {
    double rate = sim->constraints.free_acceleration[i];
    *size = fabs(rate);
    for (int j = 0; j < sim->constraints.count; j++) {
        const double part = sim->constraints.delassus[i * sim->model->n_constraints + sim->constraints.index[j]] *
                            sim->constraints.force[j];
        rate += part;
        *size += fabs(part);
    }
    return rate;
}
