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

/* Bounds of candidate number `count`, constraint i. Those of a lossy gear at rest grow with the force of its tie, along
 * the sides that are assumed. */
static void bounds_of(gb_sim *sim, int i, int count) {
    struct gb_constraints *c = &sim->constraints;
    const double *bounds = c->bounds + 5 * i, keep = 1.0 - c->shrink[i];
    c->on[count] = -1;
    if (sim->model->constraints[i].kind == GB_LOSS) {
        const gb_loss_line forward = gb_loss_on_side(bounds, sim->lossy.forward[i]),
                           backward = gb_loss_on_side(bounds, sim->lossy.backward[i]);
        c->on[count] = sim->model->constraints[i].partner;
        c->lo[count] = -keep * forward.fixed;
        c->hi[count] = keep * backward.fixed;
        c->lo_slope[count] = -keep * forward.slope;
        c->hi_slope[count] = -keep * backward.slope;
        return;
    }
    c->lo[count] = bounds[0] > -HUGE_VAL ? keep * bounds[0] : -HUGE_VAL;
    c->hi[count] = bounds[1] < HUGE_VAL ? gb_max(keep * bounds[1], c->lo[count]) : HUGE_VAL;
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

/* The complementarity problem of the candidates: forces within their bounds that keep the slips at zero. Those that
 * slip all the same slide from here; returns how many. */
static int decide(gb_sim *sim, int *code) {
    const gb_model *model = sim->model;
    const int n = model->n_constraints;
    int *index = sim->constraints.index, count = 0, lost = 0;
    double *lo = sim->constraints.lo, *hi = sim->constraints.hi, *b = sim->constraints.right,
           *x = sim->constraints.force;
    for (int i = 0; i < n; i++) {
        if (sim->constraints.decision[i] == GB_CANDIDATE && cannot_hold(sim, i)) {
            sim->constraints.decision[i] = GB_SLIDES;
            sim->mode[model->constraints[i].slip] = sim->constraints.free_acceleration[i] > 0.0 ? 1.0 : -1.0;
            lost++;
        }
        if (sim->constraints.decision[i] == GB_CANDIDATE) {
            bounds_of(sim, i, count);
            b[count] = sim->constraints.free_acceleration[i];
            index[count++] = i;
        }
    }
    const int coupled = number_ties(sim, count);
    const gb_coupled_bounds growth = {sim->constraints.on, sim->constraints.lo_slope, sim->constraints.hi_slope};
    *code = gb_solve_problem(sim, count, coupled);
    if (*code != GB_DONE) {
        return 0;
    }
    for (int i = 0; i < count; i++) {
        if (coupled) {
            lo[i] += gb_lcp_shift(&growth, i, -1, x);
            hi[i] += gb_lcp_shift(&growth, i, 1, x);
        }
        double w = b[i], size = fabs(b[i]);
        for (int j = 0; j < count; j++) {
            w += sim->constraints.matrix[i * count + j] * x[j];
            size += fabs(sim->constraints.matrix[i * count + j] * x[j]);
        }
        if (fabs(w) > gb_acceleration_rounding(sim, index[i], size) && (x[i] <= lo[i] || x[i] >= hi[i])) {
            slide(sim, index[i], w);
            sim->constraints.shrink[index[i]] = 0.0;
            lost++;
        }
    }
    if (lost == 0) {
        *code = gb_refuse_contradiction(sim, count);
    }
    sim->constraints.count = count;
    return lost;
}

int gb_choose_active_set(gb_sim *sim) {
    int code = GB_DONE;
    for (int round = 0; code == GB_DONE && round <= sim->model->n_constraints; round++) {
        code = free_accelerations(sim);
        if (code == GB_DONE) {
            sim->model->delassus(sim->par, sim->mode, sim->instant.time_terms, sim->constraints.y, 1,
                                 sim->constraints.delassus);
            if (decide(sim, &code) == 0) {
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
