#include "gb_jump.h"
#include "gb_inputs.h"
#include "gb_modes.h"
#include "gb_rest.h"

static const double PASSED = 256.0; /* roundings of time */

int gb_jump(gb_sim *sim, double t) {
    sim->head->front.t0 = sim->head->front.t1;
    sim->head->front.h = 0.0;
    sim->head->front.t1 = t;
    sim->head->ledger.turnover_segment = 0.0;
    if (t >= sim->head->events.t_break) {
        gb_mark_time_events(sim);
    }
    return GB_DONE;
}

int gb_passes_corner(gb_sim *sim) {
    struct gb_front *front = &sim->head->front;
    const double passed = PASSED * DBL_EPSILON * gb_max(fabs(front->t1), sim->head->control.h_largest);
    const double t = front->t1 + passed, since = front->t1 - front->t0; /* of the step before, or what it passed */
    if (sim->inputs.n_callbacks == 0 || !gb_is_at_rest(sim) || t >= sim->head->events.t_break ||
        fabs(since - passed) <= 8.0 * DBL_EPSILON * fabs(front->t1)) {
        return 0;
    }
    sim->head->control.h_next = 0.0; /* what comes is another motion */
    front->have_k1 = 0;
    return gb_jump(sim, t) == GB_DONE;
}

int gb_ends_at_jump(gb_sim *sim, double stop, double *limit, int *code) {
    const int found = sim->head->options.step > 0.0 ? 0 : gb_callback_jumps(sim, *limit);
    if (found > 0) {
        gb_refresh_breaks(sim, 0);
        *limit = gb_limit_of_step(sim, stop);
    }
    *code = found < 0 ? found : GB_DONE;
    return found != 0;
}
