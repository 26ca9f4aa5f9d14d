/* Impacts: stops that are hit and locks without limit that close on a slip, all at once. */
#include "gb_internal.h"
#include "gb_lock.h"
#include "gb_locks.h"

/* Stops whose impacts follow on each other within what can be told apart come to rest. */
static double restitution(const gb_sim *sim, int i) {
    const gb_head *head = sim->head;
    const double pause = head->t1 - sim->flip_time[sim->model->locks[i].slip];
    return pause <= 64.0 * gb_rounding(head->t1, head->h) ? 0.0 : sim->limit[5 * i + 2];
}

/* Bounds of the impulse of lock i and the slip that it must undo; 0: it takes no part. */
static int takes_impulse(const gb_sim *sim, int i, double *lo, double *hi, double *undo) {
    const double slip = sim->slip[i], *limit = sim->limit + 5 * i;
    *lo = limit[0] <= -HUGE_VAL ? -HUGE_VAL : 0.0;
    *hi = limit[1] >= HUGE_VAL ? HUGE_VAL : 0.0;
    *undo = slip;
    if (!gb_does_rub(sim, i) || sim->model->locks[i].kind == GB_LOSS || (*lo == 0.0 && *hi == 0.0)) {
        return 0;
    }
    if (gb_is_stop(sim, i)) {
        *undo = slip < -sim->slip_rounding[i] ? slip * (1.0 + restitution(sim, i)) : slip;
        return gb_touches(sim, i);
    }
    return 1;
}

/* What an impact did to lock i: its loss, states and event. */
static void note_impact(gb_sim *sim, int i, double impulse, double before, double after) {
    const gb_lock *lock = &sim->model->locks[i];
    const double lost = -0.5 * impulse * (before + after);
    if (lock->impulse >= 0) {
        sim->y[lock->impulse] = impulse;
    }
    if (lock->impacts >= 0) {
        sim->y[lock->impacts] += 1.0;
    }
    if (lock->loss >= 0) {
        sim->y[lock->loss] += lost;
        sim->head->turnover += fabs(lost);
    }
    gb_log(sim, lock->slip, 2, before, after);
}

/* Impulses on the locks; what prescribed motions supply to them counts as turned over. */
static void push(gb_sim *sim, const double *impulse) {
    const gb_model *model = sim->model;
    memcpy(sim->z2, sim->y, sizeof(double) * (size_t)model->n_total);
    model->push(sim->par, sim->mode, sim->tau_one, impulse, sim->y);
    for (int i = model->n_padded + model->n_angles; i < model->n_padded + model->n_tail; i++) {
        sim->head->turnover += fabs(sim->y[i] - sim->z2[i]);
    }
}

/* Impulses where a stop is hit or an unlimited lock slips; slips after it. */
int gb_impact(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int n = model->n_locks;
    int *index = sim->lock_index, count = 0, struck = 0;
    double *b = sim->lock_right, *lo = sim->lock_lo, *hi = sim->lock_hi, *p = sim->lock_force;
    for (int i = 0; i < n; i++) {
        if (takes_impulse(sim, i, &lo[count], &hi[count], &b[count])) {
            const gb_lock *lock = &model->locks[i];
            const int met =
                lock->kind == GB_FRICTION && sim->due[lock->slip] != 0.0; /* its slip has just come to zero */
            const double w = met ? 0.0 : b[count], rounding = sim->slip_rounding[i];
            struck = struck || (w < -rounding && hi[count] > 0.0) || (w > rounding && lo[count] < 0.0);
            index[count++] = i;
        }
    }
    if (!struck) {
        return GB_DONE;
    }
    model->pulls(sim->par, sim->mode, sim->tau_one, sim->y, 0, sim->response);
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < count; j++) {
            sim->lock_matrix[i * count + j] = sim->response[index[i] * n + index[j]];
        }
    }
    if (!gb_lock_box(count, sim->lock_matrix, b, lo, hi, p)) {
        return gb_fail(sim, GB_ERR_BRANCH, model->locks[index[0]].slip, sim->head->t1, b[0]);
    }
    if (gb_refuse_tie_up(sim, count) != GB_DONE) {
        return sim->head->report.code;
    }
    double *whole = sim->lock_other, *before = sim->lock_before;
    memset(whole, 0, sizeof(double) * (size_t)n);
    memcpy(before, sim->slip, sizeof(double) * (size_t)n);
    for (int i = 0; i < count; i++) {
        whole[index[i]] = p[i];
    }
    push(sim, whole);
    gb_slips_now(sim);
    for (int i = 0; i < n; i++) {
        const double rounding = sim->slip_rounding[i], own = fabs(whole[i]) * sim->response[i * n + i];
        const double lost = fabs(before[i]) > rounding && own > 1e-6 * fabs(before[i]) ? fabs(whole[i]) : 0.0;
        if (lost > 0.0 && (gb_is_stop(sim, i) || gb_is_unlimited(sim, i) || !gb_is_stuck(sim, i))) {
            note_impact(sim, i, whole[i], before[i], sim->slip[i]);
        }
        sim->struck[i] = lost > 0.0;
    }
    return GB_DONE;
}
