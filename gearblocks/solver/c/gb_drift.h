/* Drift of the energy balance: what was stored, lost and supplied must add up to the same at all times, and departs
 * from it by the errors of steps, each within its tolerance, that add up. Looked at seldom; where the run would end
 * with more than the ledger promises, steps are judged more strictly. Knows nothing of how steps are made. */
#ifndef GB_DRIFT_H
#define GB_DRIFT_H

#include "gb_internal.h"

/* After a step that was accepted, when it is time to look. */
int gb_drift_look(gb_sim *sim);

static inline int gb_drift_is_due(const gb_sim *sim) {
    return sim->head->counts.steps >= sim->head->drift.look_at;
}

#endif
