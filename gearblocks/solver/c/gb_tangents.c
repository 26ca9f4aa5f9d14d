#include "gb_tangents.h"
#include "gb_memory.h"
#include "gb_report.h"
#include "gb_run.h"
#include "gb_snapshot.h"
#include "gb_tangent_event.h"
#include "gb_tangent_graze.h"
#include "gb_tangent_parameter.h"
#include "gb_tangent_step.h"

#include <time.h>

enum { STEPS_BETWEEN_LOOKS = 16 }; /* at the clock */
static const double LOST = 1e-13;  /* of a column that the ones before it leave: nothing of its own */

/* The next `count` numbers; a null base only counts. */
static double *take(double *base, size_t *at, size_t count) {
    const size_t here = *at;
    *at += (count + GB_PAD - 1) / GB_PAD * GB_PAD;
    return base ? base + here : NULL;
}

static void lay_lanes(const gb_model *m, double *base, size_t *at, gb_lanes *lanes) {
    lanes->t = take(base, at, GB_LANES);
    lanes->u = take(base, at, (size_t)(m->n_inputs + 1) * GB_LANES);
    lanes->time_terms = take(base, at, (size_t)(m->n_time_terms + 1) * GB_LANES);
}

/* Laid out from `base` on; answers how many numbers there are. */
static size_t lay(const gb_sim *sim, int count, double *base, gb_tangent_room *room) {
    const gb_model *m = sim->model;
    const size_t total = (size_t)m->n_total, stages = GB_STAGES, columns = (size_t)(count > 0 ? count : 1);
    const size_t block = (gb_snapshot_size(sim) + sizeof(double) - 1) / sizeof(double);
    double **const vectors[] = {&room->state,  &room->combined,     &room->moved,       &room->rates,
                                &room->before, &room->rates_before, &room->rates_after, &room->beyond};
    double **const by_surface[] = {&room->functions, &room->speeds, &room->surfaces};
    size_t at = 0;
    for (size_t i = 0; i < sizeof vectors / sizeof vectors[0]; i++) {
        *vectors[i] = take(base, &at, total);
    }
    for (size_t i = 0; i < sizeof by_surface / sizeof by_surface[0]; i++) {
        *by_surface[i] = take(base, &at, (size_t)m->n_event_functions + 1);
    }
    room->slopes = take(base, &at, stages * total);
    room->columns = take(base, &at, columns * stages * total);
    room->delay = take(base, &at, columns);
    lay_lanes(m, base, &at, &room->lanes);
    for (int p = 0; p < GB_BESIDE; p++) {
        lay_lanes(m, base, &at, &room->beside[p]);
        room->par[p] = take(base, &at, (size_t)(m->n_par > m->n_parameters ? m->n_par : m->n_parameters));
        room->mode[p] = take(base, &at, gb_modes_size(m));
    }
    room->lo = take(base, &at, (size_t)m->n_switches);
    room->hi = take(base, &at, (size_t)m->n_switches);
    room->block_before = take(base, &at, block);
    room->block_after = take(base, &at, block);
    return at;
}

size_t gb_tangent_size(const gb_sim *sim, int count) {
    gb_tangent_room room;
    return lay(sim, count, NULL, &room);
}

static double product(const gb_sim *sim, const double *scale, const double *a, const double *b) {
    double sum = 0.0;
    for (int i = 0; i < sim->model->n; i++) {
        sum += a[i] / scale[i] * (b[i] / scale[i]);
    }
    return sum;
}

/* Takes out of v what lies along an orthonormal direction. */
static void take_out(const gb_sim *sim, const double *scale, const double *direction, double *v) {
    const double share = product(sim, scale, v, direction);
    for (int i = 0; i < sim->model->n; i++) {
        v[i] -= share * direction[i];
    }
}

/* Gram and Schmidt, each column twice against the fixed directions and those before it. */
static void make_orthonormal(const gb_sim *sim, gb_tangents *tangents, double *logs) {
    const size_t total = (size_t)sim->model->n_total;
    for (int c = 0; c < tangents->count; c++) {
        double *v = tangents->columns + (size_t)c * total;
        const double whole = sqrt(product(sim, tangents->scale, v, v));
        for (int pass = 0; pass < 2; pass++) {
            for (int b = 0; b < tangents->n_fixed; b++) {
                take_out(sim, tangents->scale, tangents->fixed + (size_t)b * total, v);
            }
            for (int b = 0; b < c; b++) {
                take_out(sim, tangents->scale, tangents->columns + (size_t)b * total, v);
            }
        }
        const double own = sqrt(product(sim, tangents->scale, v, v));
        const int lost = !(own > LOST * whole);
        for (int i = 0; i < sim->model->n; i++) {
            v[i] = lost ? 0.0 : v[i] / own;
        }
        logs[c] = lost ? -HUGE_VAL : log(own);
    }
}

/* What is wanted at the time that is reached. */
static void keep(const gb_sim *sim, gb_tangents *tangents) {
    const size_t total = (size_t)sim->model->n_total, count = (size_t)tangents->count, done = (size_t)tangents->done;
    if (tangents->states) {
        memcpy(tangents->states + done * total, sim->y, sizeof(double) * total);
    }
    if (tangents->maps) {
        memcpy(tangents->maps + done * count * total, tangents->columns, sizeof(double) * count * total);
    }
    if (tangents->logs) {
        make_orthonormal(sim, tangents, tangents->logs + done * count);
    }
}

/* A step or an event, and the columns with it. */
static int move(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room, double target) {
    const int is_event = sim->head->events.pending && tangents->count > 0;
    int code = is_event ? gb_tangents_before(sim, tangents, room) : GB_DONE;
    code = code == GB_DONE ? gb_move(sim, target) : code;
    if (code == GB_DONE && is_event) {
        code = gb_tangents_after(sim, tangents, room);
    } else if (code == GB_DONE) {
        code = gb_tangents_step(sim, tangents, room);
        code = code == GB_DONE && tangents->count > 0 ? gb_tangents_graze(sim, tangents, room) : code;
    }
    sim->log.count = sim->log.flushed = 0;
    return code;
}

int gb_tangents_run(gb_sim *sim, gb_tangents *tangents, double slice) {
    const clock_t until = clock() + (clock_t)(gb_min(slice, 1e6) * CLOCKS_PER_SEC);
    gb_head *head = sim->head;
    gb_tangent_room room;
    int count = 0, code = head->started ? GB_DONE : gb_fail(sim, GB_ERR_STATE, 0, 0.0, 0.0);
    if (code == GB_DONE && (sim->method->gamma > 0.0 || head->choice.automatic || !head->options.locate)) {
        code = gb_fail(sim, GB_ERR_METHOD, head->method, head->front.t1, 0.0);
    }
    if (code == GB_DONE && tangents->change && (tangents->logs || tangents->count == 0)) {
        code = gb_fail(sim, GB_ERR_STATE, 0, head->front.t1, 0.0);
    }
    lay(sim, tangents->count, tangents->room, &room);
    room.scale = tangents->scale;
    if (code == GB_DONE && tangents->change) {
        gb_parameter_points(sim, tangents->change, &room);
    }
    for (; tangents->done < tangents->n_times && code == GB_DONE; tangents->done++) {
        const double target = tangents->times[tangents->done];
        head->options.t_stop = target;
        while (code == GB_DONE && (head->front.t1 < target || head->events.pending)) {
            if (++count % STEPS_BETWEEN_LOOKS == 0 && clock() >= until) {
                return GB_PAUSE;
            }
            code = move(sim, tangents, &room, target);
        }
        if (code != GB_DONE) {
            break;
        }
        keep(sim, tangents);
    }
    return code;
}
