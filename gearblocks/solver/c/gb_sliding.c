#include "gb_sliding.h"
#include "gb_constraint_state.h"
#include "gb_dense_output.h"
#include "gb_dependence.h"
#include "gb_evaluate.h"
#include "gb_grip.h"
#include "gb_limit_bend.h"
#include "gb_limit_hold.h"
#include "gb_modes.h"
#include "gb_rates.h"
#include "gb_report.h"
#include "gb_time_terms.h"
#include "gb_turned_gears.h"
#include "gb_vector.h"

enum { HALVINGS = 60, LOOKS = 4 };

static const double BEYOND = 1e-9; /* a share this far beyond its end counts as there */

static void forget(gb_sim *sim, int i) {
    struct gb_event_state *events = &sim->head->events;
    int n = 0;
    for (int j = 0; j < events->n_sliding; j++) {
        if (events->sliding[j] != i) {
            events->resting[n] = events->resting[j];
            events->rested_at[n] = events->rested_at[j];
            events->reach[n] = events->reach[j];
            events->admitted[n] = events->admitted[j];
            events->sliding[n++] = events->sliding[j];
        }
    }
    events->n_sliding = n;
    events->by_mean = events->turned = 0;
}

/* Every share lies between its ends, as far as that can be told. */
static int shares_fit(int n, const double *share) {
    for (int j = 0; j < n; j++) {
        if (!(share[j] >= -BEYOND && share[j] <= 1.0 + BEYOND)) {
            return 0;
        }
    }
    return 1;
}

/* There are shares for all that slide, and nothing else depends on what slides. */
static int all_fits(gb_sim *sim) {
    double share[GB_SLIDING];
    sim->head->events.by_mean = 0;
    return gb_turn_gears(sim) && gb_find_shares(sim, 0, &sim->instant, 0, sim->y, share) == 2 &&
           shares_fit(sim->head->events.n_sliding, share) && !gb_others_depend(sim, sim->y, share, 1);
}

/* Switch i slides from here on, or is held (GB_HELD), its last flip so long ago; else returns 0, and nothing changes.
 */
static int begin(gb_sim *sim, int i, int resting, double since) {
    const size_t size = sizeof(double) * (size_t)sim->model->n_total;
    gb_head *head = sim->head;
    if (sim->events.role[i] != GB_ORDINARY || i >= sim->model->n_event_functions ||
        head->events.n_sliding >= GB_SLIDING || gb_slides(sim, i) || !head->options.locate ||
        gb_event_functions_now(sim) != GB_DONE || gb_time_terms_at(sim, head->front.t1) != GB_DONE) {
        return 0;
    }
    gb_mode_limits(sim);
    const double before = sim->mode[i], s = sim->events.s[i];
    const double side = fabs(s - sim->events.lo[i]) < fabs(s - sim->events.hi[i]) ? -1.0 : 1.0;
    const double far = gb_far_side(sim, i, side), below = gb_min(before, far);
    if (fabs(far - before) != 1.0) {
        return 0;
    }
    gb_set_mode(sim, i, below, 0);
    head->events.resting[head->events.n_sliding] = resting;
    head->events.sliding[head->events.n_sliding++] = i;
    memcpy(sim->z, sim->y, size);
    int fits = resting != GB_HELD || gb_hold_last(sim, since);
    if (fits && gb_grip_again(sim)) {
        fits = all_fits(sim);
        if (!fits) {
            gb_let_go_again(sim);
            memcpy(sim->y, sim->z, size);
            fits = (resting != GB_HELD || gb_hold_last(sim, since)) && all_fits(sim);
        }
    } else {
        fits = fits && all_fits(sim);
    }
    if (!fits) {
        forget(sim, i);
        gb_set_mode(sim, i, before, 0);
        memcpy(sim->y, sim->z, size);
        return 0;
    }
    head->events.rested_at[head->events.n_sliding - 1] = s;
    gb_log(sim, i, 0, before, below + 0.5);
    sim->events.armed[i] = sim->events.pending[i] = sim->events.flips[i] = 0.0;
    gb_mode_limits(sim);
    return 1;
}

int gb_slide(gb_sim *sim, int i) {
    return begin(sim, i, -1, 0.0);
}

int gb_hold(gb_sim *sim, int i, double since) {
    return begin(sim, i, GB_HELD, since);
}

void gb_leave_sliding(gb_sim *sim, int i, double mode) {
    const double below = sim->mode[i];
    forget(sim, i);
    gb_log(sim, i, 0, below + 0.5, mode);
    gb_set_mode(sim, i, mode, 0);
    sim->events.armed[i] = mode > below ? -1.0 : 1.0;
    sim->events.flips[i] = 0.0;
    sim->head->events.armed = 1;
}

/* The side of the sliding switch i on which friction c, whose slip ends at the front, holds more: of its mode 0, or 1;
 * -1 where both are alike, or it slips on. With the mean of both it could not stick. */
static int stronger_side(gb_sim *sim, int i, int c) {
    const gb_model *model = sim->model;
    const gb_constraint *of = &model->constraints[c];
    double *bounds = sim->constraints.bounds;
    if (of->kind != GB_FRICTION || gb_is_active(sim, c) || sim->events.pending[of->slip] == 0.0) {
        return -1;
    }
    model->force_bounds(sim->par, sim->mode, sim->instant.time_terms, sim->y, bounds);
    const double below = bounds[5 * c + 4];
    memcpy(sim->sliding.mode, sim->mode, sizeof(double) * sim->unlocated.n_carried);
    sim->sliding.mode[i] += 1.0;
    model->force_bounds(sim->par, sim->sliding.mode, gb_terms_above(sim, &sim->instant, 0), sim->y, bounds);
    const double above = bounds[5 * c + 4];
    return above == below ? -1 : above > below;
}

int gb_leave_at_rest(gb_sim *sim) {
    const int code = gb_time_terms_at(sim, sim->head->front.t1);
    for (int c = 0; c < sim->model->n_constraints && code == GB_DONE; c++) {
        for (int j = sim->head->events.n_sliding - 1; j >= 0; j--) {
            const int i = sim->head->events.sliding[j], side = stronger_side(sim, i, c);
            if (side >= 0) {
                gb_leave_sliding(sim, i, sim->mode[i] + side);
            }
        }
    }
    gb_mode_limits(sim);
    return code;
}

void gb_stick_by_mean(gb_sim *sim) {
    const uint64_t before = sim->head->events.by_mean;
    memcpy(sim->z, sim->y, sizeof(double) * (size_t)sim->model->n_total);
    if (gb_grip_again(sim) == 0) {
        return;
    }
    if (all_fits(sim) && sim->head->events.by_mean != before) {
        for (int c = 0; c < sim->model->n_constraints; c++) {
            if (sim->constraints.released[c]) {
                sim->events.pending[sim->model->constraints[c].slip] = 0.0;
            }
        }
        return;
    }
    sim->head->events.by_mean = before;
    gb_let_go_again(sim);
    memcpy(sim->y, sim->z, sizeof(double) * (size_t)sim->model->n_total);
}

/* One whose limit has gone away from it, as what has struck the train or a set point that jumps makes it, or else one
 * that slides or is held, which the mean holds no more, leaves; 0: there is none. */
static int leave_limits(gb_sim *sim, int fails, int turns) {
    if (gb_event_functions_now(sim) != GB_DONE || gb_time_terms_at(sim, sim->head->front.t1) != GB_DONE) {
        return 0;
    }
    for (int j = 0; j < sim->head->events.n_sliding; j++) {
        const int i = sim->head->events.sliding[j], resting = sim->head->events.resting[j];
        if (resting < 0) {
            gb_admit(sim, j);
        }
        const int way = gb_limit_moves(sim, j, sim->y, 1);
        if (way != 0 || (resting < 0 && fails) || (resting == GB_HELD && turns)) {
            const double s =
                sim->events.s[i] == 0.0 ? DBL_MIN : sim->events.s[i]; /* where it stands it does not stay */
            gb_leave_sliding(sim, i, way != 0 ? sim->mode[i] + (way > 0) : sim->model->mode_at(sim->par, i, s));
            return 1;
        }
    }
    return 0;
}

int gb_settle_sliding(gb_sim *sim) {
    double share[GB_SLIDING];
    int code = sim->head->events.n_sliding > 0 ? gb_time_terms_at(sim, sim->head->front.t1) : GB_DONE;
    while (code == GB_DONE && sim->head->events.n_sliding > 0) {
        const int n = sim->head->events.n_sliding;
        const int first = sim->head->events.sliding[0];
        const int turned = gb_turn_gears(sim);
        const int found = turned ? gb_find_shares(sim, 0, &sim->instant, 0, sim->y, share) : 0,
                  fit = found && shares_fit(n, share);
        sim->head->events.by_mean = 0;
        const int fails = found < 2 || (fit && gb_others_depend(sim, sim->y, share, 1)),
                  turns = fit && !fails && gb_slips_turn(sim, share);
        if (leave_limits(sim, fails, turns)) {
            continue;
        }
        if (fails) {
            return gb_fail(sim, GB_ERR_CHATTER, first, sim->head->front.t1, 0.0);
        }
        int worst = 0;
        for (int j = 1; j < n; j++) {
            worst = fabs(share[j] - 0.5) > fabs(share[worst] - 0.5) ? j : worst;
        }
        if (fit) {
            break;
        }
        const int i = sim->head->events.sliding[worst];
        gb_leave_sliding(sim, i, sim->mode[i] + (share[worst] > 0.5 ? 1.0 : 0.0));
    }
    gb_mode_limits(sim);
    return code;
}

/* By how much the share nearest to its end is inside, at theta of the step; which one, and where it would go. Outside
 * where another switch asks for the torque that slides: the search for events sees the lower sides alone. */
static int inside(gb_sim *sim, double theta, double *margin, int *which, double *mode) {
    double share[GB_SLIDING], *y = sim->z2;
    const int code = gb_time_terms_at(sim, sim->head->front.t0 + theta * sim->head->front.h);
    *margin = -1.0; /* where there are no shares the switch goes on below its limit */
    *which = sim->head->events.sliding[0];
    *mode = sim->mode[*which];
    if (code != GB_DONE) {
        return code;
    }
    gb_dense_states(sim, theta, y);
    for (int j = 0; j < sim->head->events.n_sliding; j++) {
        if (sim->head->events.resting[j] == GB_HELD && sim->head->events.reach[j] == 0.0) { /* since the start */
            gb_admit(sim, j);
        }
        const int way = gb_limit_moves(sim, j, y, 0);
        if (way != 0) {
            *which = sim->head->events.sliding[j];
            *mode = sim->mode[*which] + (way > 0);
            return GB_DONE;
        }
    }
    if (!gb_find_shares(sim, 0, &sim->instant, 0, y, share) ||
        (shares_fit(sim->head->events.n_sliding, share) && gb_others_depend(sim, y, share, 0))) {
        return GB_DONE;
    }
    *margin = 1.0;
    for (int j = 0; j < sim->head->events.n_sliding; j++) {
        const double room = gb_min(share[j], 1.0 - share[j]);
        if (room < *margin) {
            *margin = room;
            *which = sim->head->events.sliding[j];
            *mode = sim->mode[*which] + (share[j] > 0.5 ? 1.0 : 0.0);
        }
    }
    return GB_DONE;
}

int gb_sliding_end(gb_sim *sim, double *theta) {
    double from = 0.0, to = 2.0, margin = 1.0, mode = 0.0;
    int which = 0, code = gb_dense_complete(sim);
    for (int l = 1; l <= LOOKS && code == GB_DONE && to > 1.0; l++) {
        code = inside(sim, (double)l / LOOKS, &margin, &which, &mode);
        if (margin < -BEYOND) {
            to = (double)l / LOOKS;
        } else {
            from = (double)l / LOOKS;
        }
    }
    for (int l = 0; l < HALVINGS && to <= 1.0 && code == GB_DONE && to - from > DBL_EPSILON; l++) {
        const double middle = 0.5 * (from + to);
        code = inside(sim, middle, &margin, &which, &mode);
        from = margin < 0.0 ? from : middle;
        to = margin < 0.0 ? middle : to;
    }
    if (code == GB_DONE && to <= 1.0 && to < *theta) {
        code = inside(sim, to, &margin, &which, &mode);
        memset(sim->events.pending, 0, sizeof(double) * (size_t)sim->model->n_switches);
        sim->events.pending[which] = 4.0;
        sim->events.next_mode[which] = mode;
        *theta = to;
    }
    return code;
}
