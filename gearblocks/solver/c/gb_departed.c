#include "gb_departed.h"
#include "gb_evaluate.h"
#include "gb_event.h"
#include "gb_follow.h"
#include "gb_time_terms.h"
#include "gb_tolerance.h"
#include "gb_vector.h"

/* Steps of a look, and how far it goes, in steps of the solver. */
enum { STEPS = 16 };
static const double FURTHER = 4.0;

/* Scratch row, behind the stages that dense output may still ask for. */
enum { STATE = GB_STAGES - 4 };

/* Looks at all event functions `time` ahead, into located, and with half as many steps, into s0; whether it can. */
static int look_beyond(gb_sim *sim, double time) {
    double *state = gb_scratch_row(sim, STATE);
    const int seen = gb_follow_functions(sim, time, STEPS, state, sim->events.s0) == GB_DONE &&
                     gb_follow_functions(sim, time, 2 * STEPS, state, sim->events.located) == GB_DONE;
    return gb_time_terms_at(sim, sim->head->front.t1) == GB_DONE && seen;
}

/* Event function i, held, is no farther from its limit than the tolerance of a step leaves of it: of states that are
 * small beside what counts as size for them (from rest, or beside faster ones) only the look ahead knew the side. And
 * the motion from here does not carry it back through its limit within `time`, nor as far beyond. seen: whether the
 * look at all of them can be had, -1: not tried yet. Assumed: what tolerances admit in `until`. */
static int cannot_be_told(gb_sim *sim, int i, double time, int *seen) {
    const double side = sim->events.held_side[i], limit = side < 0.0 ? sim->events.lo[i] : sim->events.hi[i];
    if (fabs(sim->events.s[i] - limit) > sim->events.until[i]) {
        return 0;
    }
    *seen = *seen < 0 ? look_beyond(sim, time) : *seen;
    const double now = side * (sim->events.s[i] - limit), off = side * (sim->events.located[i] - limit);
    const int sure = *seen && fabs(sim->events.located[i] - sim->events.s0[i]) <= 0.3 * fabs(off);
    return !(sure && off > (now < 0.0 ? 0.0 : sim->events.until[i]));
}

int gb_departed(gb_sim *sim) {
    struct gb_event_state *events = &sim->head->events;
    const double now = sim->head->front.t1, time = gb_min(FURTHER * sim->head->front.h, events->t_break - now);
    const int code = gb_event_functions_now(sim), adaptive = !(sim->head->options.step > 0.0);
    int seen = -1;
    events->held_until = HUGE_VAL;
    sim->model->mode_limits(sim->par, sim->mode, sim->events.lo, sim->events.hi);
    if (code == GB_DONE && adaptive) {
        gb_tolerances_of_small(sim, sim->events.until);
    }
    for (int i = 0; i < sim->model->n_event_functions && code == GB_DONE; i++) {
        const int due = sim->events.held_side[i] != 0.0 && sim->events.held[i] <= now;
        if (due && adaptive && cannot_be_told(sim, i, time, &seen)) {
            sim->events.held[i] = now + FURTHER * sim->head->front.h;
        } else if (due) {
            sim->events.held_side[i] = 0.0;
        }
        if (sim->events.held_side[i] != 0.0) {
            events->held_until = gb_min(events->held_until, sim->events.held[i]);
        }
    }
    const uint64_t modes = events->mode_hash;
    const int settled = code == GB_DONE ? gb_settle_modes(sim, 1) : code;
    sim->head->front.have_k1 &= events->mode_hash == modes;
    return settled;
}
