#include "gb_watch.h"
#include "gb_record.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

static const double ACCURACY = 10.0; /* times the tolerance and the largest value: a smaller one has no sign */
static const double AT_LIMIT = 1e-2; /* of the largest value: how far from its limit one stands there */

size_t gb_watch_room(const gb_sim *sim, int count) {
    return gb_row_length(sim->model) + 2 * (size_t)count;
}

void gb_watches_begin(gb_watches *all) {
    all->from_event = 0;
    for (int j = 0; j < all->count; j++) {
        gb_watch *w = &all->of[j];
        w->count = 0;
        w->side = 0;
        w->first = w->t = NAN;
        w->least = w->low = HUGE_VAL;
        w->largest = w->high = -HUGE_VAL;
        w->value = w->known = 0.0;
        w->seen = NAN;
    }
}

/* It has come to another side between the last value that had one and v at t; level: where. */
static void count(gb_watch *w, double t, double v, double level) {
    if (w->count++ == 0) {
        const double part = isnan(w->t) || v == w->value ? 1.0 : (level - w->value) / (v - w->value);
        w->first = isnan(w->t) ? t : w->t + gb_min(gb_max(part, 0.0), 1.0) * (t - w->t);
    }
}

/* Where it may be on its side of the limits, within what it was, so that only its last value is new. */
static void bound(gb_watch *w, double limit, int is_sign) {
    w->low = w->side < 0 ? w->least : gb_max(w->least, w->side > 0 ? limit : -limit);
    w->high = w->side > 0 ? w->largest : gb_min(w->largest, w->side < 0 ? -limit : limit);
    if (w->side == 0 && is_sign) { /* of no sign, which is not a last one */
        w->low = HUGE_VAL;
    }
}

static void look(gb_watch *w, double t, double v, double accuracy) {
    w->seen = v;
    if (v > w->low && v < w->high) {
        w->t = t;
        w->value = v;
        return;
    }
    if (isnan(v)) {
        return;
    }
    w->least = gb_min(w->least, v);
    w->largest = gb_max(w->largest, v);
    const double size = gb_max(fabs(w->least), fabs(w->largest));
    const double limit = w->limit > 0.0 ? w->limit : accuracy * size;
    const int side = (v > limit) - (v < -limit), is_sign = !(w->limit > 0.0);
    if (is_sign && limit > w->known) { /* what was counted so far is less than its error */
        w->count = 0;
        w->first = NAN;
        w->side = 0;
        w->known = size;
    }
    if (side != 0 && side != w->side && (w->side != 0 || !is_sign)) {
        count(w, t, v, is_sign ? 0.0 : side * w->limit);
    }
    if (side != 0 || !is_sign) {
        w->side = side;
        w->t = t;
        w->value = v;
    }
    bound(w, limit, is_sign);
}

static void look_at_all(gb_sim *sim, gb_watches *all, double t, const double *value) {
    const double accuracy = ACCURACY * sim->head->options.rtol;
    for (int j = 0; j < all->count; j++) {
        look(&all->of[j], t, value[j], accuracy);
    }
}

/* The values at t, within the last step or at the front, by a row. */
static int values_by_row(gb_sim *sim, gb_watches *all, double t, double *value) {
    const int code = gb_write_row(sim, t, all->room);
    return code == GB_DONE ? gb_evaluate(sim, all->room, 1, all->output, all->count, value, NULL) : code;
}

/* Time terms at the front: those of the last stage of the step, where it ended there; rates: its last derivative, else
 * NULL. */
static const double *terms_at_front(gb_sim *sim, int is_step, const double **rates) {
    const gb_model *m = sim->model;
    const int last = sim->method->stages;
    const double t = sim->head->front.t1;
    *rates = NULL;
    if (!is_step || sim->head->events.pending || !sim->head->front.have_k1 || sim->lanes.t[last] != t) {
        if (gb_time_terms_at(sim, t) != GB_DONE) {
            return NULL;
        }
    } else {
        *rates = sim->k1;
        if (!m->output_time_terms) {
            return sim->lanes.time_terms + last;
        }
        sim->instant.t[0] = t;
        for (int i = 0; i < m->n_inputs; i++) {
            sim->instant.u[i * GB_LANES] = sim->lanes.u[i * GB_LANES + last];
        }
        for (int i = 0; i < m->n_time_terms; i++) {
            sim->instant.time_terms[i * GB_LANES] = sim->lanes.time_terms[i * GB_LANES + last];
        }
    }
    if (m->output_time_terms) {
        m->output_time_terms(sim->par, sim->mode, 1, sim->instant.t, sim->instant.u, sim->instant.time_terms);
    }
    return sim->instant.time_terms;
}

/* The values at the front, with what the step has computed there. */
static int values_at_front(gb_sim *sim, gb_watches *all, int is_step, double *value) {
    const int has_modes = is_step || sim->model->n_constraints == 0; /* with what follows from them */
    const double *rates, *terms = NULL;
    if (has_modes && sim->head->options.locate && sim->head->events.n_sliding == 0) {
        terms = terms_at_front(sim, is_step, &rates);
    }
    if (!terms) {
        return values_by_row(sim, all, sim->head->front.t1, value);
    }
    gb_outputs_now(sim, terms, rates, all->output, all->count, value);
    return GB_DONE;
}

/* Whether one of them stands at its limit at both ends of a step. */
static int stand_at_limits(const gb_watches *all, const double *value) {
    for (int j = 0; j < all->count; j++) {
        const gb_watch *w = &all->of[j];
        const double near = w->limit + AT_LIMIT * gb_max(gb_max(fabs(w->least), fabs(w->largest)), fabs(value[j]));
        if (fabs(w->seen) <= near && fabs(value[j]) <= near) {
            return 1;
        }
    }
    return 0;
}

int gb_watches_take(gb_sim *sim, gb_watches *all, int is_step) {
    const struct gb_front *front = &sim->head->front;
    double *value = all->room + gb_row_length(sim->model), *middle = value + all->count;
    const int between = is_step && all->from_event && sim->head->events.pending && front->t0 < front->t1;
    int code = values_at_front(sim, all, is_step, value);
    if (code == GB_DONE && between && stand_at_limits(all, value)) {
        const double t = 0.5 * (front->t0 + front->t1);
        code = values_by_row(sim, all, t, middle);
        if (code == GB_DONE) {
            look_at_all(sim, all, t, middle);
        }
    }
    all->from_event = !is_step;
    if (code == GB_DONE) {
        look_at_all(sim, all, front->t1, value);
    }
    return code;
}
