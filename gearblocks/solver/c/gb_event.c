#include "gb_event.h"
#include "gb_constraint_state.h"
#include "gb_constraint_switching.h"
#include "gb_evaluate.h"
#include "gb_exact_limit.h"
#include "gb_inputs.h"
#include "gb_limit_noise.h"
#include "gb_mode_search.h"
#include "gb_modes.h"
#include "gb_rates.h"
#include "gb_reach.h"
#include "gb_report.h"
#include "gb_sliding.h"
#include "gb_swings.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

/* What flips one after the other does not come to an end: the nearest modes that agree, where there are massless
 * groups.
 */
static int search_instead(gb_sim *sim, int code, int log) {
    if (code != GB_DONE && gb_search_modes(sim, log)) {
        code = sim->head->report.code = GB_DONE;
    }
    return code;
}

int gb_settle_modes(gb_sim *sim, int log) {
    const gb_model *model = sim->model;
    int last = -1, code = GB_DONE;
    if (model->n_switches > 0) {
        gb_mode_limits(sim);
    }
    for (int round = 0; round < GB_FLIPS && model->n_event_functions > 0; round++) {
        int changed = 0;
        code = gb_event_functions_now(sim);
        if (code == GB_DONE && gb_balance_is_singular(sim)) {
            gb_search_modes(sim, log);
        }
        for (int i = 0; i < model->n_event_functions && code == GB_DONE; i++) {
            if (sim->events.role[i] != GB_CONSTRAINED && gb_is_beyond(sim, i)) {
                const double mode = model->mode_at(sim->par, i, sim->events.s[i]);
                if (mode == sim->mode[i]) {
                    code = gb_fail(sim, GB_ERR_BRANCH, i, sim->head->front.t1, sim->events.s[i]);
                    return search_instead(sim, code, log);
                }
                gb_set_mode(sim, i, mode, log && sim->events.role[i] == GB_ORDINARY);
                sim->events.armed[i] = 0.0;
                last = i;
                changed = 1;
                code = gb_count_flip(sim, i); /* what is beyond its limit does not slide along it */
            }
        }
        if (!changed || code != GB_DONE) {
            return search_instead(sim, code, log);
        }
        gb_mode_limits(sim);
    }
    code = last < 0 ? code : gb_fail(sim, GB_ERR_BRANCH, last, sim->head->front.t1, sim->events.s[last]);
    return search_instead(sim, code, log);
}

int gb_settle_all(gb_sim *sim, int log) {
    int code = GB_DONE;
    uint64_t modes = ~sim->head->events.mode_hash;
    for (int round = 0; round < GB_FLIPS && sim->model->n_constraints > 0 && code == GB_DONE; round++) {
        code = gb_switch_constraints(sim, log);
        modes = sim->head->events.mode_hash;
        if (code == GB_DONE) {
            code = gb_settle_modes(sim, log);
        }
        if (modes == sim->head->events.mode_hash) {
            break;
        }
    }
    return code;
}

/* A spring that friction alone loads, whose balance has moved it from y0: how it comes there nobody knows. */
static int refuse_jump(gb_sim *sim, const double *y0) {
    const double share = gb_max(1e-6, 10.0 * sim->head->options.rtol);
    for (int i = 0; i < sim->model->n; i++) {
        if (fabs(sim->y[i] - y0[i]) > share * gb_max(sim->control.largest[i], fabs(y0[i]))) {
            return gb_fail(sim, GB_ERR_JUMP, i, sim->head->front.t1, sim->y[i] - y0[i]);
        }
    }
    return GB_DONE;
}

int gb_balance_massless(gb_sim *sim, int before) {
    const int at_event = before == GB_AT_EVENT, watched = at_event && sim->model->springs_alone != NULL;
    int code = sim->model->balance_massless ? gb_time_terms_at(sim, sim->head->front.t1) : GB_DONE;
    uint64_t modes = ~sim->head->events.mode_hash;
    for (int round = 0;
         round < GB_FLIPS && sim->model->balance_massless && code == GB_DONE && modes != sim->head->events.mode_hash;
         round++) {
        modes = sim->head->events.mode_hash;
        if (watched) {
            memcpy(sim->z2, sim->y, sizeof(double) * (size_t)sim->model->n);
        }
        sim->model->balance_massless(sim->par, sim->mode, sim->instant.time_terms, sim->y, before == GB_FROM_REST);
        code = watched ? refuse_jump(sim, sim->z2) : GB_DONE;
        if (code == GB_DONE) {
            code = gb_settle_modes(sim, at_event);
        }
    }
    return code;
}

static int flip_pending(gb_sim *sim) {
    int code = GB_DONE;
    for (int i = 0; i < sim->model->n_switches && code == GB_DONE; i++) {
        const double pending = sim->events.pending[i];
        if (pending == 0.0 || sim->events.role[i] == GB_CONSTRAINED) {
            continue;
        }
        sim->events.pending[i] = 0.0;
        if (gb_slides(sim, i)) {
            gb_leave_sliding(sim, i, sim->events.next_mode[i]);
        } else if (fabs(pending) == 1.0) {
            gb_set_mode(sim, i, gb_far_side(sim, i, pending), sim->events.role[i] == GB_ORDINARY);
            sim->events.armed[i] = -pending;
            sim->head->events.armed = 1;
            code = gb_count_flip_or_slide(sim, i);
        } else {
            gb_set_mode(sim, i, sim->events.next_mode[i], sim->events.role[i] == GB_ORDINARY);
        }
    }
    return code;
}

/* Whether an event function that is not affine in the states flips here. */
static int crosses_general(const gb_sim *sim) {
    for (int i = sim->model->n_affine; i < sim->model->n_event_functions && sim->model->n_arguments > 0; i++) {
        if (sim->events.pending[i] != 0.0 && sim->model->is_enclosed[i - sim->model->n_affine]) {
            return 1;
        }
    }
    return 0;
}

/* What is worth remembering of the step size in the modes that end. A law that is cut by a condition over an angle
 * bends over the time between its events: a step much longer is judged by what the law never does, and cut where it is
 * hardly right. */
static double step_worth(const gb_sim *sim) {
    const double lasted = sim->head->front.t1 - sim->head->events.entered, worked = sim->head->control.h_worked;
    return crosses_general(sim) ? gb_min(worked, gb_max(1.25 * lasted, 0.02 * worked)) : worked;
}

/* The step size that worked last in these modes, where there is one; they may have lasted no longer than time is told.
 * In others nothing is known of what their laws do inside a step. */
static void recall_step(gb_sim *sim) {
    gb_head *head = sim->head;
    const size_t slot = (size_t)(head->events.mode_hash % GB_MEMORY);
    if (head->events.remembered_step[slot] > 0.0 && head->events.remembered_modes[slot] == head->events.mode_hash) {
        head->control.h_next = gb_max(head->events.remembered_step[slot], gb_rounding(head->front.t1, 0.0));
    } else {
        head->control.h_trusted = 0.0;
        gb_reach_anew(sim);
    }
}

/* Of the largest speed: none but rounding; of the speed at which a contact begins: that of a body that was at rest. */
static const double NO_SPEED = 1e-12, AT_REST = 1e-3;

/* The inverse speeds of contacts that would begin at the start of the step, there or back, whichever is slower; 0: at
 * rest. */
static void inverses_at_start(gb_sim *sim, double *inverse) {
    const gb_model *model = sim->model;
    double *y = sim->sliding.rates;
    memset(inverse, 0, sizeof(double) * (size_t)model->n);
    for (int back = 0; back <= 1; back++) {
        memcpy(y, sim->y0, sizeof(double) * (size_t)model->n);
        for (int i = model->n - model->n_speeds; i < model->n && back; i++) {
            y[i] = -y[i];
        }
        model->update_states(sim->par, sim->events.mode_before, sim->mode, sim->instant.time_terms, y);
        for (int k = 0; k < model->n_inverse_speeds; k++) {
            const int j = model->inverse_speeds[k];
            inverse[j] = gb_max(inverse[j], fabs(y[j]));
        }
    }
}

/* Contacts that began from rest on their corner: their gap is there at the start of the step too, at rest, and where
 * the step has left it is told no better than its dense output does. The inverse of the speed there would damp the
 * contact for ever. before: the states before they were set; struck: what moves there does so by a strike. */
static void forget_starts_from_rest(gb_sim *sim, const double *before, int struck) {
    const gb_model *model = sim->model;
    const double *time_terms = sim->instant.time_terms;
    const double largest = gb_max(gb_largest_speed(sim, sim->control.largest), gb_largest_speed(sim, sim->y));
    double *inverse = sim->sliding.rates + 2 * model->n_total;
    const int stepped = sim->head->front.h > 0.0 && !struck;
    if (stepped) {
        inverses_at_start(sim, inverse);
        model->event_functions(sim->par, sim->mode, time_terms, sim->y, sim->sliding.functions);
    }
    for (int k = 0; k < model->n_inverse_speeds; k++) {
        const int j = model->inverse_speeds[k], i = model->inverse_speed_switches[k];
        const double set = fabs(sim->y[j]), moved = sim->events.s0[i] - sim->sliding.functions[i];
        if (sim->y[j] == before[j] || set == 0.0) {
            continue;
        }
        const int rests = stepped && (inverse[j] == 0.0 || inverse[j] * AT_REST > set);
        if (set * NO_SPEED * largest >= 1.0 || (rests && gb_is_noise(sim, i, moved, time_terms, sim->y, sim->y0))) {
            sim->y[j] = 0.0;
        }
    }
}

/* Strikes so far, where contacts ask for them. */
static double count_strikes(const gb_sim *sim) {
    double count = 0.0;
    for (int i = 0; i < sim->model->n_constraints && sim->model->n_inverse_speeds > 0; i++) {
        count += sim->constraints.impacts[i];
    }
    return count;
}

/* A contact that touches, and that nothing has pressed yet, begins as a strike elsewhere drives its bodies together. */
static void begin_struck(gb_sim *sim) {
    const gb_model *model = sim->model;
    model->event_functions(sim->par, sim->mode, sim->instant.time_terms, sim->y, sim->sliding.functions);
    for (int k = 0; k < model->n_inverse_speeds; k++) {
        const int j = model->inverse_speeds[k], i = model->inverse_speed_switches[k];
        const double limit = sim->mode[i] > 0.0 ? sim->events.lo[i] : sim->events.hi[i];
        const double pressed = sim->sliding.functions[i] - limit;
        if (sim->y[j] == 0.0 && gb_is_noise(sim, i, pressed, sim->instant.time_terms, sim->y, sim->y0)) {
            sim->events.mode_before[i] = 0.0;
        }
    }
}

/* States of Hold; struck: by an event that had strikes. */
static int update_states(gb_sim *sim, int struck) {
    const gb_model *model = sim->model;
    const int code = gb_time_terms_at(sim, sim->head->front.t1);
    double *before = sim->sliding.rates + model->n_total;
    if (code != GB_DONE) {
        return code;
    }
    if (struck) {
        begin_struck(sim);
    }
    memcpy(before, sim->y, sizeof(double) * (size_t)model->n);
    model->update_states(sim->par, sim->events.mode_before, sim->mode, sim->instant.time_terms, sim->y);
    if (memcmp(before, sim->y, sizeof(double) * (size_t)model->n) != 0) {
        forget_starts_from_rest(sim, before, struck);
    }
    return GB_DONE;
}

int gb_update_states(gb_sim *sim) {
    return update_states(sim, 0);
}

/* How many switches rest or are held on limits; one more where the mean of sides that slide holds constraints. */
static int count_rests(const gb_sim *sim) {
    int count = sim->head->events.by_mean != 0;
    for (int j = 0; j < sim->head->events.n_sliding; j++) {
        count += sim->head->events.resting[j] != -1;
    }
    return count;
}

int gb_settle_on_limits(gb_sim *sim) {
    const int before = count_rests(sim);
    int code = sim->head->events.n_sliding > 0 ? gb_settle_sliding(sim) : GB_DONE;
    if (code == GB_DONE && count_rests(sim) < before) {
        code = gb_settle_all(sim, 1);
    }
    return code;
}

/* All that follows from the modes at an event. */
static int settle_event(gb_sim *sim, int log) {
    int code = gb_settle_modes(sim, log);
    if (code == GB_DONE) {
        code = gb_settle_all(sim, log);
    }
    if (code == GB_DONE) {
        code = gb_balance_massless(sim, GB_AT_EVENT);
    }
    return code == GB_DONE ? gb_settle_on_limits(sim) : code;
}

int gb_settle_exact_limits(gb_sim *sim, int log) {
    int code = GB_DONE, changed = sim->model->n_exact_switches > 0;
    for (int round = 0; round < GB_FLIPS && changed && code == GB_DONE; round++) {
        changed = 0;
        code = gb_take_exact_modes(sim, log, &changed);
        if (code == GB_DONE && changed) {
            code = settle_event(sim, log);
        }
    }
    return code;
}

int gb_apply_event(gb_sim *sim) {
    gb_head *head = sim->head;
    if (sim->model->update_states != NULL) {
        memcpy(sim->events.mode_before, sim->mode, sizeof(double) * (size_t)sim->model->n_switches);
    }
    const uint64_t modes = head->events.mode_hash;
    const double strikes = count_strikes(sim);
    const size_t slot = (size_t)(modes % GB_MEMORY);
    head->events.remembered_modes[slot] = modes;
    head->events.remembered_step[slot] = step_worth(sim);
    head->events.entered = head->front.t1;
    head->events.pending = 0;
    head->front.have_k1 = 0;
    head->front.row_due = 1;
    head->control.log_error = head->control.h_feature = 0.0;
    const int timed = head->front.t1 >= head->events.t_break;
    if (timed) {
        gb_input_find(sim, head->front.t1, 1);
    }
    int code = flip_pending(sim);
    if (code == GB_DONE && head->events.n_sliding > 0) {
        code = gb_leave_at_rest(sim);
    }
    if (code == GB_DONE && head->events.n_sliding > 0 && sim->model->n_constraints > 0) {
        gb_stick_by_mean(sim);
    }
    if (code == GB_DONE) {
        code = settle_event(sim, 1);
    }
    if (timed) {
        gb_refresh_breaks(sim, 0);
    }
    if (code == GB_DONE) {
        code = gb_settle_exact_limits(sim, 1);
    }
    if (code == GB_DONE && sim->model->update_states != NULL) {
        code = update_states(sim, count_strikes(sim) > strikes);
    }
    if (head->events.mode_hash != modes) {
        recall_step(sim);
        gb_reach_changed(sim);
    }
    if (sim->model->n_constraints > 0) { /* a step much longer than a bounce could not tell the bounce */
        head->control.h_next = gb_min(head->control.h_next, 2.0 * head->events.flight);
    }
    return code;
}
