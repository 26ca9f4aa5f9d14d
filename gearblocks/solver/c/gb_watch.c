#include "gb_watch.h"
#include "gb_record.h"
#include "gb_vector.h"

static const double ACCURACY = 10.0; /* times the tolerance and the largest value: a smaller one has no sign */

size_t gb_watch_room(const gb_sim *sim, int count) {
    return (size_t)(GB_LANES + 1) * (gb_row_length(sim->model) + (size_t)count);
}

void gb_watches_begin(gb_watches *all) {
    all->rows = 0;
    all->from_event = 0;
    for (int j = 0; j < all->count; j++) {
        gb_watch *w = &all->of[j];
        w->count = 0;
        w->side = 0;
        w->first = w->t = NAN;
        w->least = HUGE_VAL;
        w->largest = -HUGE_VAL;
        w->value = w->known = 0.0;
    }
}

/* It has come to another side between the last value that had one and v at t; level: where. */
static void count(gb_watch *w, double t, double v, double level) {
    if (w->count++ == 0) {
        const double part = isnan(w->t) || v == w->value ? 1.0 : (level - w->value) / (v - w->value);
        w->first = isnan(w->t) ? t : w->t + gb_min(gb_max(part, 0.0), 1.0) * (t - w->t);
    }
}

static void look(gb_watch *w, double t, double v, double accuracy) {
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
}

int gb_watches_end(gb_sim *sim, gb_watches *all) {
    const size_t length = gb_row_length(sim->model), n = (size_t)all->count;
    double *f = all->room + (size_t)(GB_LANES + 1) * length;
    const double accuracy = ACCURACY * sim->head->options.rtol;
    const int code = gb_evaluate(sim, all->room, all->rows, all->output, all->count, f, NULL);
    for (long i = 0; i < all->rows; i++) {
        for (size_t j = 0; j < n; j++) {
            look(&all->of[j], all->room[(size_t)i * length], f[(size_t)i * n + j], accuracy);
        }
    }
    all->rows = 0;
    return code;
}

/* The row at t, behind those that wait. */
static int add(gb_sim *sim, gb_watches *all, double t) {
    return gb_write_row(sim, t, all->room + (size_t)all->rows++ * gb_row_length(sim->model));
}

int gb_watches_take(gb_sim *sim, gb_watches *all, int is_step) {
    const struct gb_front *front = &sim->head->front;
    int code = GB_DONE;
    if (is_step && all->from_event && sim->head->events.pending && front->t0 < front->t1) {
        code = add(sim, all, 0.5 * (front->t0 + front->t1));
    }
    all->from_event = !is_step;
    if (code == GB_DONE) {
        code = add(sim, all, front->t1);
    }
    return code == GB_DONE && all->rows >= GB_LANES ? gb_watches_end(sim, all) : code;
}
