/* Drift of the energy balance: what was stored, lost and supplied must add up to the same at all times, and departs
 * from it by the errors of steps, each within its tolerance, that add up. Looked at seldom; where the run would end
 * with more than the ledger promises, steps are judged more strictly. Knows nothing of how steps are made. */
#ifndef GB_DRIFT_H
#define GB_DRIFT_H

#include "gb_features.h"

/* log2 of what the step of size h just computed adds to the balance, in units of its tolerance: an embedded estimate
 * passes zero by chance. -100 for a while where a shorter try of a step did not help. Assumed: the stages and the end
 * of the step, in lanes and z. */
double gb_log_imbalance(gb_sim *sim, double h);

/* Where gains change with the position few states move much at once: every step; else one that moves a narrow feature
 * of a law. */
static inline int gb_imbalance_is_due(const gb_sim *sim, double h) {
    return (sim->model->varying_inertia || gb_moves_feature(sim, h)) && sim->model->energy_sign &&
           sim->head->options.locate && !sim->head->choice.large_step;
}

/* After a step that was accepted, when it is time to look. */
int gb_drift_look(gb_sim *sim);

static inline int gb_drift_is_due(const gb_sim *sim) {
    const struct gb_drift *drift = &sim->head->drift;
    return sim->head->counts.steps >= drift->look_at || sim->head->counts.events >= drift->look_event;
}

#endif
