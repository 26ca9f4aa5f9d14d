#include "gb_report.h"

int gb_fail(gb_sim *sim, int code, int index, double t, double value) {
    const gb_report report = {code, index, t, value};
    sim->head->report = report;
    return code;
}

int gb_check_finite(gb_sim *sim, int code, const double *x, int count, int shift, double t) {
    for (int i = 0; i < count; i++) {
        if (!(x[i] - x[i] == 0.0)) {
            return gb_fail(sim, code, shift + i, t, x[i]);
        }
    }
    return GB_DONE;
}

void gb_log(gb_sim *sim, int index, int kind, double before, double after) {
    sim->head->counts.events++;
    if (sim->log.count < sim->log.capacity) {
        const gb_event event = {sim->head->front.t1, before, after, index, kind};
        sim->log.event[sim->log.count++] = event;
    }
}

void gb_get_stats(const gb_sim *sim, gb_stats *stats) {
    const gb_head *head = sim->head;
    const gb_stats now = {.t = head->front.t1,
                          .step = head->options.step > 0.0 ? head->options.step : head->control.h_next,
                          .turnover = head->ledger.turnover,
                          .steps = head->counts.steps,
                          .rejected = head->counts.rejected,
                          .rhs_calls = head->counts.rhs_calls,
                          .events = head->counts.events,
                          .jacobians = head->counts.jacobians,
                          .method = head->method,
                          .n_switches = head->choice.n_switches};
    *stats = now;
    memcpy(stats->steps_by, head->counts.steps_by, sizeof stats->steps_by);
    memcpy(stats->switch_method, head->choice.switch_method, sizeof stats->switch_method);
    memcpy(stats->switch_t, head->choice.switch_t, sizeof stats->switch_t);
}

void gb_get_report(const gb_sim *sim, gb_report *report) {
    *report = sim->head->report;
}
