#include "gb_swings.h"
#include "gb_dense_output.h"
#include "gb_evaluate.h"
#include "gb_limit_rest.h"
#include "gb_modes.h"
#include "gb_report.h"
#include "gb_sliding.h"
#include "gb_time_terms.h"
#include "gb_tolerance.h"
#include "gb_vector.h"

enum { IN_VAIN = 8 };                  /* flips without progress are counted so far */
enum { SETTLED = 64 };                 /* flips since the shortest swing: rounding keeps them up */
enum { TOO_MANY = 10000, LOOKS = 64 }; /* swings in a row; of so many it is asked whether anything tells them */
static const double NO_STEP = 1e-6; /* of the largest step: flips that follow so closely come of rounding, or in vain */
static const double CLOSE = 1e-3;   /* of the largest step: flips that may be swings of nothing */
static const double LEFT = 20.0;    /* times as long: the rest of a run that is given up */
static const double NARROW =
    1e-2; /* of the tolerance: how far swings that nothing tells take it; see gb_limit_hold.h */

/* Counts flips in a row of swings that may be none; whether the shortest of them is long ago. */
static int have_settled(gb_sim *sim, int i, double since) {
    double *shortest = sim->events.shortest + i, *at = sim->events.shortest_at + i, *swings = sim->events.swings + i;
    *swings += 1.0;
    if (*swings <= 1.0 || since < *shortest) {
        *shortest = since;
        *at = *swings;
    }
    if (*swings <= 1.0) {
        sim->events.swings_from[i] = sim->head->front.t1;
    }
    return *swings - *at > SETTLED;
}

/* The last step, which ended on the limit of switch i, has taken it no farther away than nothing tells. */
static int is_narrow(gb_sim *sim, int i) {
    const struct gb_front *front = &sim->head->front;
    const double half = 0.5 * (front->t1 - front->t0);
    double *y = sim->z, *s = sim->sliding.functions;
    if (!(front->h > 0.0) || gb_event_functions_now(sim) != GB_DONE || gb_dense_complete(sim) != GB_DONE ||
        gb_time_terms_at(sim, front->t0 + half) != GB_DONE) {
        return 0;
    }
    gb_dense_states(sim, half / front->h, y);
    sim->model->event_functions(sim->par, sim->mode, sim->instant.time_terms, y, s);
    const double way = fabs(s[i] - sim->events.s[i]);
    return gb_time_terms_at(sim, front->t1) == GB_DONE && way <= NARROW * gb_tolerance_of(sim, i);
}

/* Swings that nothing tells any more, that have settled and come to no rest, are too many, where many times as many are
 * to come. */
static int refuse_swings(gb_sim *sim, int i, int settled) {
    const double t = sim->head->front.t1, lasted = t - sim->events.swings_from[i];
    double *swings = sim->events.swings + i;
    if (*swings > TOO_MANY && !(settled && sim->head->events.target - t > LEFT * lasted && is_narrow(sim, i))) {
        *swings = 0.0;
    }
    return *swings > TOO_MANY + LOOKS ? gb_fail(sim, GB_ERR_CHATTER, i, t, -*swings) : GB_DONE;
}

int gb_count_flip_or_slide(gb_sim *sim, int i) {
    const double before = sim->events.flips[i], since = sim->head->front.t1 - sim->events.flip_time[i];
    const int code = gb_count_flip(sim, i), far = since > CLOSE * sim->head->control.h_largest;
    if (far && sim->events.flips[i] == 1.0) { /* as nearly all do */
        sim->events.swings[i] = 0.0;
        gb_come_to_rest(sim, i, since, 0);
        return code;
    }
    const int settled = have_settled(sim, i, since);
    if (code != GB_DONE || (sim->events.flips[i] > 2.0 && gb_slide(sim, i))) {
        return code;
    }
    if (sim->events.flips[i] == 1.0 && since <= NO_STEP * sim->head->control.h_largest) {
        sim->events.flips[i] = gb_min(before + 1.0, IN_VAIN + 1.0);
    }
    if (gb_come_to_rest(sim, i, gb_max(since, DBL_MIN), settled) ||
        ((!far || sim->events.flips[i] > 2.0) && gb_hold(sim, i, since))) {
        return GB_DONE;
    }
    return refuse_swings(sim, i, settled);
}
