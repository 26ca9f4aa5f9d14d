#include "gb_progress.h"
#include "gb_error_control.h"
#include "gb_report.h"

enum { CROWD = 100000 }; /* events in a row that must bring the run on */

/* By what part of the rest of the run: as many events, as many refused tries. */
static const double BY_EVENTS = 1e-5, BY_TRIES = 1e-12;

int gb_progress_of_events(gb_sim *sim, double target) {
    gb_head *head = sim->head;
    const long long crowd = head->counts.events - head->events.crowd;
    if (crowd < CROWD) {
        return GB_DONE;
    }
    const double progress = head->front.t1 - head->events.t_crowd;
    const int index = sim->log.count > 0 ? sim->log.event[sim->log.count - 1].index : 0;
    head->events.crowd = head->counts.events;
    head->events.t_crowd = head->front.t1;
    return progress < BY_EVENTS * (target - head->front.t1)
               ? gb_fail(sim, GB_ERR_CHATTER, index, head->front.t1, (double)crowd)
               : GB_DONE;
}

int gb_look_at_tries(gb_sim *sim, double target, int in_doubt) {
    gb_head *head = sim->head;
    const int first = head->events.tries == 0;
    const double progress = head->front.t1 - (first ? head->front.t_start : head->events.t_tries);
    const int which = sim->events.undersampled ? sim->events.undersampled : sim->events.in_doubt;
    const int untold = in_doubt ? which : 0;
    const long long tries = head->counts.rejected - head->events.tries;
    head->events.tries = head->counts.rejected;
    head->events.t_tries = head->front.t1;
    if (progress >= BY_TRIES * gb_rest_of_run(sim, target)) {
        return GB_DONE;
    }
    return gb_fail(sim, GB_ERR_STALL, untold > 0 ? sim->model->n + untold - 1 : gb_worst_state(sim), head->front.t1,
                   (double)tries);
}
