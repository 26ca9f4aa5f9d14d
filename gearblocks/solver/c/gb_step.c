#include "gb_step.h"
#include "gb_account.h"
#include "gb_angle_wrapping.h"
#include "gb_constraint_state.h"
#include "gb_cut.h"
#include "gb_defect.h"
#include "gb_dense_output.h"
#include "gb_drift.h"
#include "gb_error_control.h"
#include "gb_evaluate.h"
#include "gb_features.h"
#include "gb_force_bounds.h"
#include "gb_give_up.h"
#include "gb_growth.h"
#include "gb_jump.h"
#include "gb_ledger.h"
#include "gb_locate.h"
#include "gb_massless_error.h"
#include "gb_method_choice.h"
#include "gb_modes.h"
#include "gb_progress.h"
#include "gb_rates.h"
#include "gb_reach.h"
#include "gb_rest.h"
#include "gb_rosenbrock.h"
#include "gb_runge_kutta.h"
#include "gb_sliding.h"
#include "gb_stage_modes.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

/* Another try with a shorter step; a rate inside the step is not finite. */
enum { AGAIN = 100, NOT_FINITE };

/* A size that reaches so nearly to an announced instant is stretched to it; a shorter one after a try is shorter still.
 */
static const double NEARLY = 1.01, SHORTER = 0.98;

/* By how much a step that nobody looked into lengthens what is trusted: many that grow by little each grow far. */
static const double LITTLE = 1.05;

static void last_derivative(gb_sim *sim) {
    const int last = sim->method->stages;
    double *k = sim->k + (size_t)last * (size_t)sim->model->n_total;
    sim->head->counts.rhs_calls++;
    if (!sim->head->options.locate) {
        gb_stage_rates(sim, last, 1, sim->z, k);
        return;
    }
    gb_rates(sim, 1, &sim->lanes, last, sim->z, k);
}

/* Where a step of size h from the front ends: on the grid, at an announced instant, or where it likes. */
static double end_of_step(const gb_sim *sim, double h, double limit) {
    const gb_head *head = sim->head;
    const double t = head->front.t1, step = head->options.step;
    if (step > 0.0) {
        const double count = floor((t - head->front.t_start) / step + 1e-9) + 1.0;
        const double grid = head->front.t_start + count * step;
        return limit - grid < 1e-9 * step ? limit : grid;
    }
    if (t + NEARLY * h >= limit) {
        return limit;
    }
    return t + 2.0 * h > limit ? t + 0.5 * (limit - t) : t + h;
}

/* The step that began at `from` and would have ended at `end` counts: scales, ledger, sizes. */
static int count_step(gb_sim *sim, double from, double end) {
    gb_head *head = sim->head;
    gb_forget_underflow(sim->y, sim->model->n_constraints > 0 ? sim->model->n : 0);
    gb_scales_grow(sim, sim->y);
    gb_ledger_take(sim);
    if (head->ledger.turnover > GB_BEYOND) {
        return gb_name_growth(sim);
    }
    const double trusted = head->control.h_trusted;
    head->control.h_trusted = gb_max(0.9 * trusted, gb_min(end - from, LITTLE * trusted));
    head->control.h_largest = gb_max(head->control.h_largest, head->front.t1 - from);
    head->drift.imbalanced = 0;
    head->counts.steps++;
    head->counts.steps_by[head->method]++;
    head->front.row_due |= head->front.t1 > from;
    return gb_drift_is_due(sim) ? gb_drift_look(sim) : GB_DONE;
}

/* Takes the step over: the front moves to its end or to the first event inside it. AGAIN: it was too long for that.
 * NOT_FINITE: it is to be rejected, as one whose own stages are not. */
static int accept(gb_sim *sim, double end) {
    const gb_model *model = sim->model;
    gb_head *head = sim->head;
    const double from = head->front.t1;
    double theta = 2.0;
    if (head->options.step > 0.0 && sim->method->gamma == 0.0 && gb_watch_fixed_step(sim, end - from) != GB_DONE) {
        return head->report.code;
    }
    head->front.t0 = from;
    head->front.h = end - from;
    if (model->n_event_functions > 0 && head->options.locate) {
        const int code = gb_locate(sim, &theta);
        if (code != GB_DONE) {
            return code == GB_ERR_NAN_RATE && !(head->options.step > 0.0) ? NOT_FINITE : code;
        }
        if (head->events.n_sliding > 0 && gb_sliding_end(sim, &theta) < 0) {
            return head->report.code;
        }
        sim->events.part = gb_part_again(sim, theta);
        if (sim->events.part < 1.0) { /* the next try may not find the event */
            memset(sim->events.pending, 0, sizeof(double) * (size_t)model->n_event_functions);
            return AGAIN;
        }
    }
    if (theta <= 1.0) {
        gb_dense_cut(sim, theta);
        const int code = gb_ledger_cut(sim, theta);
        if (code != GB_DONE) {
            return code;
        }
        head->events.pending = 1;
        head->front.have_k1 = 0;
    } else {
        gb_copy(sim->y, sim->z, model->n_total);
        gb_copy(sim->k1, sim->k + (size_t)sim->method->stages * (size_t)model->n_total, model->n_total);
        if (model->n_wrapped > 0) {
            gb_wrapping_advance(sim);
        }
        head->front.t1 = end;
        if (!head->options.locate && gb_mark_modes(sim) != GB_DONE) {
            return head->report.code;
        }
    }
    if (head->front.t1 >= head->events.t_break) { /* also where a switch of the state is pending there */
        gb_mark_time_events(sim);
    }
    if (!head->events.pending && gb_slips_remain(sim, sim->lanes.time_terms + sim->method->stages)) {
        head->front.have_k1 = 0;
    }
    if (head->events.armed && head->front.t1 - from > 10.0 * gb_rounding(from, head->front.h)) {
        memset(sim->events.armed, 0, sizeof(double) * (size_t)model->n_event_functions);
        head->events.armed = 0;
    }
    return count_step(sim, from, end);
}

/* What the estimates of the states, of which `error` is the largest, do not see: the largest of all, likewise. */
static double other_errors(gb_sim *sim, double h, double error) {
    const gb_model *model = sim->model;
    if (model->n_quadratures > model->n_angles) {
        error = gb_account_worse(sim, error, gb_ledger_log_error(sim, h, error), GB_BY_LEDGER);
    }
    if (error <= 0.0 && model->n_massless > 0 && sim->method->gamma == 0.0) {
        error = gb_account_worse(sim, error, gb_log_massless_error(sim, h, error), GB_BY_MASSLESS);
    }
    if (error <= 0.0 && gb_reach_is_due(sim, h)) {
        error = gb_account_worse(sim, error, gb_log_reach(sim, h), GB_BY_REACH);
    }
    if (error <= 0.0 && gb_imbalance_is_due(sim, h)) {
        error = gb_account_worse(sim, error, gb_log_imbalance(sim, h), GB_BY_BALANCE);
    }
    if (error <= 0.0 && gb_defect_is_due(sim, h)) {
        error = gb_account_worse(sim, error, gb_log_defect(sim, h),
                                 GB_BY_DEFECT); /* last: its rows stay where the step is good */
    }
    return error;
}

/* The error of the step just computed, as log2 in units of the tolerance; NaN when a rate or the new state is not
 * finite. */
static double judge(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const gb_method *method = sim->method;
    const gb_head *head = sim->head;
    const gb_weights *e = &method->e[0];
    const int early = e->index[e->count - 1] == method->stages;
    const double *k_new = sim->k + (size_t)method->stages * (size_t)model->n_total;
    const int implicit = method->gamma > 0.0, adaptive = !(head->options.step > 0.0);
    double error = -100.0;
    gb_account_error(sim, GB_BY_STATE);
    if (early) {
        last_derivative(sim);
    }
    if (adaptive) {
        const int old = implicit && (head->front.t1 - head->front.t_start >
                                         2.0 * (head->control.t_weights - head->front.t_start) + h ||
                                     gb_noise_is_of_longer(sim, h));
        if (head->control.h_weights == 0.0 || h > 2.0 * head->control.h_weights || old ||
            gb_weights_follow_trial(sim)) {
            gb_error_weights(sim, h, &sim->lanes, head->control.unscaled || head->counts.steps == 0 ? sim->z : NULL);
        }
        error = (head->choice.large_step ? gb_large_step_error(sim, h) : gb_log_error(sim, h)) + head->drift.strictness;
    }
    error += gb_taint(sim->z, implicit ? model->n_padded : model->n_total);
    if (error <= 0.0) {
        if (!early) {
            last_derivative(sim);
        }
        error += gb_taint(k_new, model->n_total);
        if (implicit) {
            gb_rosenbrock_quadratures(sim, h);
            error += gb_taint(sim->z + model->n_padded, model->n_total - model->n_padded);
        }
    }
    return error <= 0.0 && adaptive ? other_errors(sim, h, error) : error;
}

/* Time terms, the derivative at the front and all stages of a step that ends at `end`. */
static int try_step(gb_sim *sim, double end) {
    const gb_method *method = sim->method;
    const double from = sim->head->front.t1, h = end - from;
    for (int j = 0; j < method->all_stages; j++) {
        sim->lanes.t[j] = method->c[j] == 1.0 ? end : from + method->c[j] * h;
    }
    const int implicit = method->gamma > 0.0;
    const int more = implicit ? gb_rosenbrock_lanes(sim, from, h, sim->lanes.t + method->all_stages) : 0;
    const int code = gb_time_terms(sim, method->all_stages + more, &sim->lanes);
    if (code != GB_DONE) {
        return code;
    }
    if (!sim->head->front.have_k1 && gb_first_derivative(sim, &sim->lanes) != GB_DONE) {
        return sim->head->report.code;
    }
    if (implicit) {
        return gb_rosenbrock_stages(sim, h);
    }
    gb_copy(sim->k, sim->k1, sim->model->n_total);
    if (sim->head->options.locate) {
        gb_run_stages(sim, h);
    } else {
        gb_run_stages_unlocated(sim, h);
    }
    return GB_DONE;
}

/* Before the first step, and after an event: its size, once the derivative is known; scales of what has none. */
static int prepare_first(gb_sim *sim) {
    int code = gb_time_terms_at(sim, sim->head->front.t1);
    if (code == GB_DONE && !sim->head->front.have_k1) {
        code = gb_first_derivative(sim, &sim->instant);
    }
    const int scaled = code == GB_DONE && gb_scales_from_rest(sim);
    if (code == GB_DONE && (scaled || sim->head->control.h_next == 0.0)) {
        code = gb_time_terms_at(sim, sim->head->front.t1);
        memcpy(sim->k, sim->k1, sizeof(double) * (size_t)sim->model->n_total);
        sim->head->control.h_next = gb_first_step(sim);
    }
    return code;
}

/* The next step size after a step of `size` that the step control wanted to be `wanted`. */
static void propose(gb_sim *sim, double error, double size, double wanted, int rejected) {
    gb_head *head = sim->head;
    const double factor = head->options.step > 0.0 ? 1.0 : gb_step_factor(sim, error, 1);
    head->control.h_next = size * (rejected ? gb_min(factor, 1.0) : factor);
    head->control.h_worked = gb_min(head->control.h_next, size);
    if (size < 0.9 * wanted && !rejected) {
        head->control.h_worked = head->control.h_next = gb_max(head->control.h_next, wanted);
    }
}

/* The size that the control wants, within every limit of it. */
static double wanted_step(gb_sim *sim) {
    const gb_head *head = sim->head;
    double h = gb_reach_step(sim, gb_min(head->control.h_next, head->options.max_step));
    h = head->control.h_feature > 0.0 ? gb_min(h, head->control.h_feature) : h;
    h = sim->model->n_wrapped > 0 ? gb_wrapping_step(sim, h) : h;
    gb_account_size(sim, h);
    return h;
}

/* The step just computed is as good as its error says, and short enough for the narrow features of the laws: the part
 * of it that may be kept. */
static double part_kept(gb_sim *sim, double error, double size) {
    const int asked = error <= 0.0 && sim->model->n_features > 0 && !(sim->head->options.step > 0.0);
    const double part = asked ? gb_features_part(sim, size) : 1.0;
    if (part < 1.0) {
        gb_account_refused(sim, GB_BY_FEATURE);
    }
    return part < 1.0 ? gb_min(part, SHORTER) : 1.0;
}

/* What size and method the step begins with. */
static int prepare(gb_sim *sim, double limit) {
    const gb_head *head = sim->head;
    const int fresh = head->control.h_next == 0.0 || (!head->front.have_k1 && gb_is_at_rest(sim));
    const int code = fresh && !(head->options.step > 0.0) ? prepare_first(sim) : GB_DONE;
    return code == GB_DONE ? gb_choice_look(sim, limit) : code;
}

int gb_step(gb_sim *sim, double stop) {
    gb_head *head = sim->head;
    int rejected = 0, code = sim->model->n_wrapped > 0 ? gb_wrap_angles(sim, 1) : GB_DONE;
    double limit = gb_limit_of_step(sim, stop);
    gb_copy(sim->y0, sim->y, sim->model->n_total);
    head->front.h = head->front.have_dense = head->front.have_quadratures = sim->events.again = 0;
    if (code == GB_DONE && gb_is_at(sim, limit)) {
        return gb_jump(sim, limit);
    }
    code = code == GB_DONE ? prepare(sim, limit) : code;
    double h = wanted_step(sim);
    while (code == GB_DONE) {
        const double end = end_of_step(sim, h, limit), size = end - head->front.t1;
        if (!(size > 0.0)) { /* lost in the rounding of the time */
            return gb_give_up(sim, GB_DONE, 1, h);
        }
        code = try_step(sim, end);
        if (code != GB_DONE && code != GB_ERR_SINGULAR) {
            break;
        }
        if (code == GB_DONE && sim->inputs.n_callbacks > 0 && gb_ends_at_jump(sim, stop, &limit, &code)) {
            continue;
        }
        double error = code == GB_DONE ? judge(sim, size) : NAN;
        const double part = part_kept(sim, error, size);
        if (part < 1.0) {
            h = part * size;
            continue;
        }
        if (error <= 0.0) {
            propose(sim, error, size, h, rejected);
            code = accept(sim, end);
            if (code != AGAIN && code != NOT_FINITE) {
                gb_account_accepted(sim, end, limit);
                return code;
            }
            error = code == AGAIN ? error : NAN;
            code = code == AGAIN ? GB_DONE : GB_ERR_NAN_RATE;
            head->front.have_dense = 0;
        }
        rejected = 1;
        gb_account_refused(sim, isnan(error) ? GB_BY_FAILURE : error <= 0.0 ? GB_BY_DOUBT : GB_BY_STATE);
        if (error <= 0.0) {
            sim->events.again++;
            h = sim->events.part * size;
            code = gb_progress_of_tries(sim, stop, 1);
            continue;
        }
        gb_forget_trial(sim, error);
        h = head->options.step > 0.0
                ? 0.0
                : gb_choice_rejected(sim, size * (error > 0.0 ? gb_step_factor(sim, error, 0) : 0.1));
        if (h < 16.0 * DBL_EPSILON * gb_max(fabs(head->front.t1), head->control.h_largest) || h < 1e-200) {
            return gb_give_up(sim, code, error > 0.0, h);
        }
        head->report.code = GB_DONE;
        code = gb_progress_of_tries(sim, stop, 0);
    }
    return code;
}
