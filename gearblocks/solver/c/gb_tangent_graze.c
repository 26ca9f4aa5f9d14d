#include "gb_tangent_graze.h"
#include "gb_dense_output.h"
#include "gb_event_values.h"
#include "gb_rates.h"
#include "gb_tangent_event.h"
#include "gb_time_terms.h"

static const double TOUCHES = 1e-8; /* of what an event function moves in the step: so near a limit it may be at it */
static const double BEGUN =
    1e-9; /* of a later slope: the rounding of one that begins at 0, as of what has just let go */
static const double BESIDE = 0.02; /* of the step: points of the parabola around an extremum */

/* The extremum of event function i, near theta, into value: the vertex of a parabola through three points of the dense
 * output. */
static int vertex(gb_sim *sim, int i, double theta, double *value) {
    double s[3];
    theta = gb_min(gb_max(theta, BESIDE), 1.0 - BESIDE);
    for (int p = 0; p < 3; p++) {
        const int code = gb_event_functions_at(sim, theta + BESIDE * (p - 1), sim->events.s);
        if (code != GB_DONE) {
            return code;
        }
        s[p] = sim->events.s[i];
    }
    const double bend = s[0] - 2.0 * s[1] + s[2], slope = 0.5 * (s[2] - s[0]);
    *value = bend != 0.0 ? s[1] - 0.5 * slope * slope / bend : s[1];
    return GB_DONE;
}

int gb_tangents_graze(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room) {
    const gb_model *model = sim->model;
    const struct gb_front *front = &sim->head->front;
    const double h = front->t1 - front->t0;
    if (model->n_affine == 0 || !(h > 0.0) || sim->head->events.pending) {
        return GB_DONE;
    }
    int code = gb_time_terms_at(sim, front->t1);
    gb_rates(sim, 0, &sim->instant, 0, sim->y, room->rates_after);
    model->directions(sim->par, room->slopes, room->speeds);
    model->directions(sim->par, room->rates_after, room->surfaces);
    for (int i = 0; i < model->n_affine && code == GB_DONE; i++) {
        const double from = room->speeds[i], to = room->surfaces[i], moves = h * (fabs(from) + fabs(to));
        const double limit = from > 0.0 ? sim->events.hi[i] : sim->events.lo[i];
        if (!(from * to < 0.0) || !(fabs(limit) < HUGE_VAL) || fabs(from) <= BEGUN * fabs(to)) {
            continue;
        }
        double value = 0.0;
        code = gb_dense_complete(sim);
        code = code == GB_DONE ? vertex(sim, i, from / (from - to), &value) : code;
        if (code == GB_DONE && fabs(value - limit) <= TOUCHES * moves) {
            tangents->doubt = 1;
            tangents->surface = i;
            gb_tangents_note(tangents, front->t0 + h * from / (from - to));
        }
    }
    return code;
}
