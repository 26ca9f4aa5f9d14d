#include "gb_start.h"
#include "gb_angle_wrapping.h"
#include "gb_constraint_state.h"
#include "gb_constraint_switching.h"
#include "gb_dense_output.h"
#include "gb_departure.h"
#include "gb_error_control.h"
#include "gb_evaluate.h"
#include "gb_event.h"
#include "gb_inputs.h"
#include "gb_memory.h"
#include "gb_method_choice.h"
#include "gb_mode_search.h"
#include "gb_modes.h"
#include "gb_report.h"
#include "gb_rosenbrock.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

/* Derived parameters, natural scales and lanes of constants. */
static int take_values(gb_sim *sim, double t) {
    const gb_model *model = sim->model;
    int code = gb_check_finite(sim, GB_ERR_NAN_START, sim->par, model->n_parameters, model->n, t);
    if (code == GB_DONE) {
        code = gb_check_finite(sim, GB_ERR_NAN_INPUT, sim->inputs.value, model->n_inputs, 0, t);
    }
    if (code == GB_DONE) {
        model->prepare(sim->par);
        sim->panel.known = 0;
        model->scales(sim->par, sim->control.natural_scale);
        sim->head->control.natural = -1.0;
        gb_size_rows(sim);
        gb_kinematic_links(sim);
        gb_input_broadcast(sim);
        gb_input_find(sim, t, 0);
    }
    return code;
}

static void clear_run(gb_sim *sim, const gb_options *options, double t0) {
    const gb_model *m = sim->model;
    gb_head *head = sim->head;
    const gb_head fresh = {.key = head->key, .bytes = head->bytes, .options = *options};
    const size_t switches = sizeof(double) * (size_t)m->n_switches, states = sizeof(double) * (size_t)m->n_padded;
    *head = fresh;
    head->front.t_start = head->front.t0 = head->front.t1 = head->front.t_comm = head->events.entered = t0;
    head->events.t_break = head->events.held_until = HUGE_VAL;
    head->front.row_due = 1;
    memset(sim->mode, 0, switches + sizeof(double) * (size_t)m->n_active_set);
    memset(sim->events.armed, 0, switches);
    memset(sim->events.pending, 0, switches);
    memset(sim->events.flips, 0, switches);
    memset(sim->events.held, 0, switches);
    memset(sim->events.held_side, 0, switches);
    memset(sim->events.shortest, 0, switches);
    memset(sim->events.shortest_at, 0, switches);
    memset(sim->events.swings, 0, switches);
    memset(sim->events.swings_from, 0, switches);
    memset(sim->constraints.impacts, 0, sizeof(double) * (size_t)m->n_constraints);
    memset(sim->constraints.impact_speed, 0, 2 * sizeof(double) * (size_t)m->n_constraints);
    for (int i = 0; i < m->n_switches; i++) {
        sim->events.flip_time[i] = sim->events.stayed[i] = -HUGE_VAL;
    }
    memset(sim->control.largest, 0, states);
    memset(sim->control.natural_scale, 0, states);
    memset(sim->control.noise, 0, states);
    memset(sim->control.error_weight, 0, states);
    memset(sim->control.least_scale, 0, states);
    memset(sim->control.fast, 0, states);
    memset(sim->control.fastest_rate, 0, states);
    gb_choice_start(sim);
    gb_set_method(sim, options->method == GB_AUTO ? head->choice.explicit_method : options->method);
    sim->log.count = sim->log.flushed = 0;
}

/* On a limit exactly: the mode follows the direction of motion (right limit), and begins here: states that take a value
 * with it do so. Affine event functions; the others are told by the first step. */
static int start_on_limits(gb_sim *sim) {
    const gb_model *model = sim->model;
    int code = gb_time_terms_at(sim, sim->head->front.t1);
    if (code == GB_DONE) {
        code = gb_first_derivative(sim, &sim->instant);
    }
    sim->head->front.have_k1 = 0;
    if (code != GB_DONE) {
        return code;
    }
    model->directions(sim->par, sim->k1, sim->events.slopes);
    if (model->update_states != NULL) {
        memcpy(sim->events.mode_before, sim->mode, sizeof(double) * (size_t)model->n_switches);
    }
    for (int i = 0; i < model->n_affine; i++) {
        if (sim->events.role[i] == GB_CONSTRAINED) {
            continue;
        }
        const double rounding = 64.0 * DBL_EPSILON * fabs(sim->events.s[i]) + DBL_MIN;
        const double side = fabs(sim->events.s[i] - sim->events.lo[i]) <= rounding
                                ? -1.0
                                : fabs(sim->events.s[i] - sim->events.hi[i]) <= rounding;
        if (side != 0.0 && side * sim->events.slopes[i] < 0.0 && model->update_states != NULL) {
            sim->events.mode_before[i] = gb_far_side(sim, i, side);
        }
        if (side != 0.0 && side * sim->events.slopes[i] > 0.0) {
            gb_set_mode(sim, i, gb_far_side(sim, i, side), 0);
            sim->events.armed[i] = -side;
            sim->head->events.armed = 1;
        }
    }
    code = gb_settle_modes(sim, 0);
    if (code == GB_DONE) {
        code = gb_settle_all(sim, 0);
    }
    return code == GB_DONE && model->update_states != NULL ? gb_update_states(sim) : code;
}

/* A switch of the state whose mode is not the one of its event function, or -1. Of several the first that goes back to
 * mode 0: friction at a shaft without inertia has a switch for each direction, and sticks before it goes the other way.
 */
static int first_apart(const gb_sim *sim) {
    const gb_model *model = sim->model;
    int first = -1;
    for (int i = model->n_event_functions - 1; i >= 0; i--) {
        const double mode = model->mode_at(sim->par, i, sim->events.s[i]);
        if (sim->events.role[i] != GB_CONSTRAINED && mode != sim->mode[i] &&
            (first < 0 || mode == 0.0 || model->mode_at(sim->par, first, sim->events.s[first]) != 0.0)) {
            first = i;
        }
    }
    return first;
}

/* Modes of the state's switches until they agree with each other: all at once, and one at a time where that goes in
 * circles (for a complementarity problem with one solution that ends: Murty 1974). */
static int modes_of_state(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int most = GB_FLIPS + 8 * model->n_event_functions;
    int first = 0, code = GB_DONE;
    for (int round = 0; round < most && model->n_event_functions > 0 && code == GB_DONE; round++) {
        code = gb_event_functions_now(sim);
        if (code == GB_DONE && gb_balance_is_singular(sim) && gb_search_modes(sim, 0)) {
            return code;
        }
        first = code == GB_DONE ? first_apart(sim) : first;
        if (code != GB_DONE || first < 0) {
            return code;
        }
        const int all = round < GB_FLIPS, to = all ? model->n_event_functions : first + 1;
        for (int i = all ? 0 : first; i < to; i++) {
            if (sim->events.role[i] != GB_CONSTRAINED) {
                gb_set_mode(sim, i, model->mode_at(sim->par, i, sim->events.s[i]), 0);
            }
        }
    }
    return code == GB_DONE && model->n_event_functions > 0 && !gb_search_modes(sim, 0)
               ? gb_fail(sim, GB_ERR_BRANCH, first, sim->head->front.t1, sim->events.s[first])
               : code;
}

/* Start values are worked out with modes (a ratio law on its segment), and modes with start values: until both stay. */
static int start_with_modes(gb_sim *sim) {
    const gb_model *model = sim->model;
    const size_t size = sizeof(double) * (size_t)model->n_total;
    int code = modes_of_state(sim);
    for (int round = 0; round < GB_FLIPS && code == GB_DONE; round++) {
        memcpy(sim->z, sim->y, size);
        code = gb_time_terms_at(sim, sim->head->front.t1);
        model->start(sim->par, sim->mode, sim->instant.time_terms, sim->y);
        gb_wrap_angles(sim, 0);
        if (code != GB_DONE || memcmp(sim->z, sim->y, size) == 0) {
            break;
        }
        gb_scales_grow(sim, sim->y);
        code = modes_of_state(sim);
    }
    return code;
}

/* Modes at the start: those of time just after it, then those of the state. fresh: its values are those of
 * model->start. */
static int start_modes(gb_sim *sim, int fresh) {
    const gb_model *model = sim->model;
    gb_time_modes(sim, 0);
    int code = fresh && model->n_event_functions > 0 ? start_with_modes(sim) : modes_of_state(sim);
    if (code != GB_DONE) {
        return code;
    }
    code = gb_settle_modes(sim, 0);
    if (code == GB_DONE) {
        code = gb_settle_all(sim, 0);
    }
    if (code == GB_DONE) {
        code = gb_balance_massless(sim, fresh ? GB_FROM_REST : GB_GOING_ON);
    }
    if (code == GB_DONE && model->n_affine > 0) {
        code = start_on_limits(sim);
    }
    if (code == GB_DONE) {
        code = gb_settle_exact_limits(sim, 0);
    }
    return code == GB_DONE ? gb_depart(sim, fresh ? GB_FROM_REST : GB_GOING_ON, 1) : code;
}

int gb_start(gb_sim *sim, const gb_options *options, double t0, const double *y0) {
    const gb_model *model = sim->model;
    if (options->method < 0 || options->method > GB_AUTO) {
        return gb_fail(sim, GB_ERR_STATE, options->method, t0, 0.0);
    }
    if (options->method == GB_RODAS && !model->pattern) {
        return gb_fail(sim, GB_ERR_METHOD, options->method, t0, 0.0);
    }
    clear_run(sim, options, t0);
    int code = take_values(sim, t0);
    if (code == GB_DONE) {
        memset(sim->y, 0, sizeof(double) * (size_t)model->n_total);
        gb_time_modes(sim, 0);
        code = gb_time_terms_at(sim, t0);
    }
    if (code == GB_DONE) {
        model->start(sim->par, sim->mode, sim->instant.time_terms, sim->y);
        if (y0) {
            memcpy(sim->y, y0, sizeof(double) * (size_t)model->n_total);
        }
        code = gb_check_finite(sim, GB_ERR_NAN_START, sim->y, model->n, 0, t0);
    }
    if (code == GB_DONE) {
        gb_wrap_angles(sim, 0);
        gb_scales_grow(sim, sim->y);
        code = start_modes(sim, y0 == NULL);
    }
    sim->head->started = code == GB_DONE;
    return code;
}

int gb_apply_changes(gb_sim *sim) {
    const gb_model *model = sim->model;
    gb_head *head = sim->head;
    if (!head->changed || !head->started) {
        return head->report.code;
    }
    gb_dense_all(sim, head->front.t_comm, sim->z);
    if (head->front.t_comm < head->front.t1) {
        const double share =
            head->front.h > 0.0 ? (head->front.t_comm - head->front.t0) / (head->front.t1 - head->front.t0) : 1.0;
        head->ledger.turnover -= (1.0 - share) * head->ledger.turnover_segment;
        /* Only a step that is passed to its end lets the next one grow: where changes cut every step short and the
         * motion is a polynomial in time, it would grow without bound. */
        head->control.h_next = gb_min(head->control.h_next, gb_max(head->front.h, head->control.h_worked));
        head->events.pending = 0;
        memset(sim->events.pending, 0, sizeof(double) * (size_t)sim->model->n_switches);
    }
    memcpy(sim->y, sim->z, sizeof(double) * (size_t)sim->model->n_total);
    head->front.t0 = head->front.t1 = head->front.t_comm;
    head->front.h = 0.0;
    head->front.have_dense = head->front.have_quadratures = head->front.have_k1 = head->changed = 0;
    head->drift.based = 0;
    head->control.h_weights = 0.0;
    head->control.least_scale_at = 0;
    head->control.log_error = 0.0;
    head->report.code = GB_DONE;
    int code = take_values(sim, head->front.t1);
    if (code == GB_DONE) {
        gb_time_modes(sim, 1);
        code = gb_settle_modes(sim, 1);
    }
    if (code == GB_DONE && model->n_constraints > 0) {
        code = gb_switch_constraints(sim, 1);
    }
    if (code == GB_DONE) {
        code = gb_settle_on_limits(sim);
    }
    return code == GB_DONE ? gb_settle_exact_limits(sim, 1) : code;
}
