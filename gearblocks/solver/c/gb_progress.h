/* Limits of progress: events, or tries of steps, that follow on each other and hardly bring the run on, so that it
 * would not end. Knows nothing of what makes them. */
#ifndef GB_PROGRESS_H
#define GB_PROGRESS_H

#include "gb_inline.h"
#include "gb_internal.h"
#include "gb_vector.h"

/* s. No machine is watched for longer: a run of a train by itself may be given any end. */
#define GB_LONGEST 1e6

/* What is left of a run. */
static inline double gb_rest_of_run(const gb_sim *sim, double target) {
    return gb_min(target - sim->head->front.t1, GB_LONGEST);
}

/* Refused tries in a row that must bring the run on by a part of what is left of it. */
enum { GB_TRIES = 400 };

/* After an event: GB_ERR_CHATTER by the switch of the last one. */
int gb_progress_of_events(gb_sim *sim, double target);

/* After GB_TRIES more tries that were refused, the last in doubt of what it met or with too large an error:
 * GB_ERR_STALL by what was in doubt (as n + switch), or by the state with the largest error. */
int gb_look_at_tries(gb_sim *sim, double target, int in_doubt);

/* After a try that was refused. */
GB_INLINE int gb_progress_of_tries(gb_sim *sim, double target, int in_doubt) {
    const gb_head *head = sim->head;
    return head->counts.rejected - head->events.tries < GB_TRIES ? GB_DONE : gb_look_at_tries(sim, target, in_doubt);
}

#endif
