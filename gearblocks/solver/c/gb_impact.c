#include "gb_impact.h"
#include "gb_constraint_state.h"
#include "gb_limit_noise.h"
#include "gb_modes.h"
#include "gb_report.h"
#include "gb_vector.h"

/* Stops whose impacts follow on each other within what can be told apart, in time or in the height of the flight
 * between them (a quarter of its duration times its speed), come to rest: the end of a flight lower than the rounding
 * of its gap is located no better than that, and would give back the speed that the impact took. */
static double restitution(gb_sim *sim, int i) {
    const gb_head *head = sim->head;
    const int gap = sim->model->constraints[i].slip;
    const double pause = head->front.t1 - sim->events.flip_time[gap];
    const double height = 0.25 * pause * fabs(sim->constraints.slip[i]);
    if (pause <= 64.0 * gb_rounding(head->front.t1, head->front.h) ||
        (height < HUGE_VAL && gb_is_noise(sim, gap, height, sim->instant.time_terms, sim->y, sim->y))) {
        return 0.0;
    }
    return sim->constraints.bounds[5 * i + 2];
}

/* Bounds of the impulse of constraint i and the slip that it must undo; 0: it takes no part. */
static int takes_impulse(gb_sim *sim, int i, double *lo, double *hi, double *undo) {
    const double slip = sim->constraints.slip[i], *bounds = sim->constraints.bounds + 5 * i;
    *lo = bounds[0] <= -HUGE_VAL ? -HUGE_VAL : 0.0;
    *hi = bounds[1] >= HUGE_VAL ? HUGE_VAL : 0.0;
    *undo = slip;
    if (!gb_is_engaged(sim, i) || sim->model->constraints[i].kind == GB_LOSS || (*lo == 0.0 && *hi == 0.0)) {
        return 0;
    }
    if (gb_is_stop(sim, i)) {
        *undo = slip < -sim->constraints.slip_rounding[i] ? slip * (1.0 + restitution(sim, i)) : slip;
        return gb_touches(sim, i);
    }
    return 1;
}

/* What an impact did to constraint i: its loss, states and event. */
static void note_impact(gb_sim *sim, int i, double impulse, double before, double after) {
    const gb_constraint *constraint = &sim->model->constraints[i];
    const double lost = -0.5 * impulse * (before + after);
    if (constraint->impulse >= 0) {
        sim->y[constraint->impulse] = impulse;
    }
    if (constraint->impacts >= 0) {
        sim->y[constraint->impacts] += 1.0;
    }
    if (constraint->loss >= 0) {
        sim->y[constraint->loss] += lost;
        sim->head->ledger.turnover += fabs(lost);
    }
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

int gb_impact(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int n = model->n_constraints;
    int struck = 0;
    double *b = sim->constraints.right, *lo = sim->constraints.lo, *hi = sim->constraints.hi;
    for (int i = 0; i < n; i++) {
        sim->constraints.in[i] = takes_impulse(sim, i, &lo[i], &hi[i], &b[i]);
        if (sim->constraints.in[i]) {
            const gb_constraint *constraint = &model->constraints[i];
            const int met = constraint->kind == GB_FRICTION &&
                            sim->events.pending[constraint->slip] != 0.0; /* its slip has just come to zero */
            const double w = met ? 0.0 : b[i], rounding = sim->constraints.slip_rounding[i];
            struck = struck || (w < -rounding && hi[i] > 0.0) || (w > rounding && lo[i] < 0.0);
        }
    }
    if (!struck) {
        return GB_DONE;
    }
    model->delassus(sim->par, sim->mode, sim->instant.time_terms, sim->y, 0, sim->constraints.delassus);
    if (gb_solve_problem(sim, 0) != GB_DONE || gb_refuse_contradiction(sim) != GB_DONE) {
        return sim->head->report.code;
    }
    const gb_delassus W = gb_delassus_of(sim);
    double *whole = sim->constraints.other, *before = sim->constraints.slip_before;
    memcpy(whole, sim->constraints.force, sizeof(double) * (size_t)n);
    memcpy(before, sim->constraints.slip, sizeof(double) * (size_t)n);
    apply_impulses(sim, whole);
    slips_after(sim);
    for (int i = 0; i < n; i++) {
        const double rounding = sim->constraints.slip_rounding[i], own = fabs(whole[i]) * gb_delassus_diagonal(&W, i);
        const double lost = fabs(before[i]) > rounding && own > 1e-6 * fabs(before[i]) ? fabs(whole[i]) : 0.0;
        if (lost > 0.0 && (gb_is_stop(sim, i) || gb_is_unbounded(sim, i) || !gb_is_active(sim, i))) {
            note_impact(sim, i, whole[i], before[i], sim->constraints.slip[i]);
        }
        sim->constraints.struck[i] = lost > 0.0;
    }
    return GB_DONE;
}
