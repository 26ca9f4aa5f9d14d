#include "gb_inputs.h"
#include "gb_report.h"
#include "gb_vector.h"

/* Of what a callback changes by between two samples: what is left of it between nearer ones, where it jumps. How far
 * behind a step it is looked whether it stays as it is, as part of the step. */
static const double LEFT = 0.5, LITTLE = 1e-3;

/* Number of whole periods before t, and the time within its period. */
static double periods(const gb_source *s, double t) {
    return s->period > 0.0 ? floor((t - s->x[0]) / s->period) : 0.0;
}

/* The last point at or before t, or -1. */
static int find_point(const gb_source *s, double t) {
    int low = -1, high = s->points;
    while (high - low > 1) {
        const int middle = low + (high - low) / 2;
        if (s->x[middle] <= t) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

/* Where segment `cell` ends. Segments are counted through all periods. */
static double end_of_cell(const gb_source *s, double cell) {
    if (s->period > 0.0) {
        const double count = floor(cell / s->points);
        const int i = (int)(cell - count * s->points);
        return (i + 1 < s->points ? s->x[i + 1] : s->x[0] + s->period) + count * s->period;
    }
    return cell + 1.0 < s->points ? s->x[(int)cell + 1] : HUGE_VAL;
}

static double cell_of(const gb_source *s, double t) {
    const double count = periods(s, t);
    double cell = count * s->points + find_point(s, t - count * s->period);
    while (end_of_cell(s, cell) <= t) {
        cell += 1.0;
    }
    return cell;
}

/* The value at t of the piece of curve that belongs to segment `cell`. */
static double table_value(const gb_source *s, double cell, double t) {
    const double count = s->period > 0.0 ? floor(cell / s->points) : 0.0;
    const int i = (int)(cell - count * s->points);
    const int j = i + 1 < s->points ? i + 1 : 0;
    if (i < 0 || s->kind == GB_STEP || (s->period <= 0.0 && i + 1 >= s->points)) {
        return s->y[i < 0 ? 0 : i];
    }
    const double end = j > 0 ? s->x[j] : s->x[0] + s->period;
    const double width = end - s->x[i];
    const double b = (t - count * s->period - s->x[i]) / width, a = 1.0 - b;
    double value = s->y[i] == s->y[j] ? s->y[i] : a * s->y[i] + b * s->y[j]; /* what rests does so exactly */
    if (s->kind == GB_CUBIC && s->y2) {
        value += ((a * a * a - a) * s->y2[i] + (b * b * b - b) * s->y2[j]) * (width * width / 6.0);
    }
    return value;
}

/* The value of callback i, whose piece goes on beyond the instant at which it is known to jump. */
static int callback_value(gb_sim *sim, int i, double t, double *value) {
    const gb_source *s = &sim->inputs.source[i];
    const double end = sim->inputs.cell_end[i];
    *value = 0.0;
    return s->fn(s->user, i, t < end ? t : nextafter(end, -HUGE_VAL), value) == 0
               ? GB_DONE
               : gb_fail(sim, GB_ERR_CALLBACK, i, t, *value);
}

static int moving_value(gb_sim *sim, int i, double t, double *value) {
    const gb_source *s = &sim->inputs.source[i];
    const int code = s->kind == GB_CALLBACK ? callback_value(sim, i, t, value) : GB_DONE;
    if (code != GB_DONE) {
        return code;
    }
    *value = s->kind == GB_CALLBACK ? *value : table_value(s, sim->inputs.cell[i], t);
    return *value - *value == 0.0 ? GB_DONE : gb_fail(sim, GB_ERR_NAN_INPUT, i, t, *value);
}

/* Begins the piece of callback i behind its jump. What fails there is said by the next step. */
static void leave_jump(gb_sim *sim, int i, double t) {
    double before, after;
    int code = callback_value(sim, i, t, &before);
    sim->inputs.cell_end[i] = HUGE_VAL;
    code = code == GB_DONE ? callback_value(sim, i, t, &after) : code;
    if (code == GB_DONE && before != after) { /* else it comes to rest */
        gb_log(sim, sim->model->n_switches + i, 1, before, after);
    }
}

void gb_input_find(gb_sim *sim, double t, int log) {
    for (int m = 0; m < sim->inputs.n_moving; m++) {
        const int i = sim->inputs.moving[m];
        const gb_source *s = &sim->inputs.source[i];
        if (s->kind == GB_CALLBACK && !log) {
            sim->inputs.cell[i] = 0.0;
            sim->inputs.cell_end[i] = HUGE_VAL;
        } else if (s->kind == GB_CALLBACK && sim->inputs.cell_end[i] <= t) {
            leave_jump(sim, i, t);
        } else if (s->kind != GB_CALLBACK && (!log || sim->inputs.cell_end[i] <= t)) {
            const double before = log ? table_value(s, sim->inputs.cell[i], t) : 0.0;
            sim->inputs.cell[i] = cell_of(s, t);
            sim->inputs.cell_end[i] = end_of_cell(s, sim->inputs.cell[i]);
            if (log && s->kind == GB_STEP) {
                gb_log(sim, sim->model->n_switches + i, 1, before, table_value(s, sim->inputs.cell[i], t));
            }
        }
    }
}

/* The two neighbours in time among the lanes between which input i changes most: the lane of the earlier one, and that
 * of the later one; by how much, and the largest value. */
static double most_change(const double *t, const double *u, int lanes, int *from, int *to, double *largest) {
    double most = 0.0;
    *largest = 0.0;
    for (int l = 0; l < lanes; l++) {
        int next = -1;
        for (int k = 0; k < lanes; k++) {
            next = t[k] > t[l] && (next < 0 || t[k] < t[next]) ? k : next;
        }
        if (next >= 0 && fabs(u[next] - u[l]) > most) {
            most = fabs(u[next] - u[l]);
            *from = l;
            *to = next;
        }
        *largest = fabs(u[l]) > *largest ? fabs(u[l]) : *largest;
    }
    return most;
}

/* Halves (from, to] down to neighbouring times, always where callback i changes more, and keeps the second of them as
 * the end of its piece where most of the change is left: 1. What is steep alone changes by a part of it there. */
static int find_jump(gb_sim *sim, int i, double limit, double from, double to, double before, double after) {
    const double whole = fabs(after - before);
    double value, middle = 0.5 * (from + to);
    while (from < middle && middle < to && fabs(after - before) >= LEFT * whole) {
        const int code = moving_value(sim, i, middle, &value);
        if (code != GB_DONE) {
            return code;
        }
        const int left = fabs(value - before) > fabs(value - after);
        *(left ? &to : &from) = middle;
        *(left ? &after : &before) = value;
        middle = 0.5 * (from + to);
    }
    if (fabs(after - before) < LEFT * whole) {
        return 0;
    }
    double earlier = before, later = after; /* a value of one time alone is no jump; asked is up to the limit */
    int code = from > sim->head->front.t1 ? moving_value(sim, i, nextafter(from, -HUGE_VAL), &earlier) : GB_DONE;
    if (code == GB_DONE && to < limit) {
        code = moving_value(sim, i, nextafter(to, HUGE_VAL), &later);
    }
    if (code != GB_DONE || fabs(later - earlier) < LEFT * whole) {
        return code;
    }
    sim->inputs.cell_end[i] = to;
    return 1;
}

/* Halves (from, to] for where callback i comes to `rest`, or leaves it, which it `begins` to have at `to` or had at
 * `from`; a time of rest is kept as the end of a piece: 1. */
static int find_corner(gb_sim *sim, int i, double from, double to, double rest, int begins) {
    const double end = sim->lanes.t[sim->method->stages];
    int code = GB_DONE;
    for (double middle = 0.5 * (from + to); code == GB_DONE && from < middle && middle < to;
         middle = 0.5 * (from + to)) {
        double value;
        code = moving_value(sim, i, middle, &value);
        *((value == rest) == begins ? &to : &from) = middle;
    }
    const double corner = begins ? to : from;
    if (code == GB_DONE && corner > sim->head->front.t1 && corner < end) {
        sim->inputs.cell_end[i] = corner;
        return 1;
    }
    return code;
}

/* Callback i stays as it is at the start of the step for a while, or at its end, and not at both: what is exactly on
 * the limit of a condition begins to be so there, or ceases to. */
static int find_rest(gb_sim *sim, int i, const double *t, const double *u) {
    const int last = sim->method->stages;
    const double start = sim->head->front.t1, little = LITTLE * (t[last] - start);
    double soon, later, left = t[last], came = start;
    if (u[0] == u[last] || sim->inputs.cell_end[i] < HUGE_VAL) {
        return GB_DONE;
    }
    int code = moving_value(sim, i, start + little, &soon);
    code = code == GB_DONE ? moving_value(sim, i, t[last] + little, &later) : code;
    if (code != GB_DONE) {
        return code;
    }
    for (int l = 0; l <= last; l++) {
        left = u[l] != u[0] ? gb_min(left, t[l]) : left;
        came = u[l] != u[last] ? gb_max(came, t[l]) : came;
    }
    if (soon == u[0]) {
        return find_corner(sim, i, start, left, u[0], 0);
    }
    return later == u[last] ? find_corner(sim, i, came, t[last], u[last], 1) : GB_DONE;
}

int gb_callback_jumps(gb_sim *sim, double limit) {
    const double *t = sim->lanes.t;
    int found = 0;
    for (int m = 0; m < sim->inputs.n_moving && found >= 0; m++) {
        const int i = sim->inputs.moving[m];
        const double *u = sim->lanes.u + (size_t)i * GB_LANES;
        int from = 0, to = 0;
        double largest;
        if (sim->inputs.source[i].kind == GB_CALLBACK &&
            most_change(t, u, sim->method->stages + 1, &from, &to, &largest) > sim->head->options.rtol * largest) {
            int jumps = find_jump(sim, i, limit, t[from], t[to], u[from], u[to]);
            jumps = jumps == 0 && sim->model->n_exact_timed > 0 ? find_rest(sim, i, t, u) : jumps;
            found = jumps != 0 ? jumps : found;
        }
    }
    return found;
}

int gb_input_lanes(gb_sim *sim, int lanes, const double *t, double *u) {
    for (int m = 0; m < sim->inputs.n_moving; m++) {
        double *lane = u + (size_t)sim->inputs.moving[m] * GB_LANES;
        for (int l = 0; l < lanes; l++) {
            const int code = moving_value(sim, sim->inputs.moving[m], t[l], &lane[l]);
            if (code != GB_DONE) {
                return code;
            }
        }
        for (int l = lanes; l < GB_LANES; l++) {
            lane[l] = lane[lanes - 1];
        }
    }
    return GB_DONE;
}

int gb_input_values(gb_sim *sim, double t, double *value) {
    memcpy(value, sim->inputs.value, sizeof(double) * (size_t)sim->model->n_inputs);
    for (int m = 0; m < sim->inputs.n_moving; m++) {
        const int code = moving_value(sim, sim->inputs.moving[m], t, &value[sim->inputs.moving[m]]);
        if (code != GB_DONE) {
            return code;
        }
    }
    return GB_DONE;
}

void gb_input_broadcast(gb_sim *sim) {
    for (int i = 0; i < sim->model->n_inputs; i++) {
        for (int l = 0; l < GB_LANES; l++) {
            sim->lanes.u[i * GB_LANES + l] = sim->inputs.value[i];
            sim->instant.u[i * GB_LANES + l] = sim->inputs.value[i];
        }
    }
}

static void list_moving(gb_sim *sim) {
    sim->inputs.n_moving = sim->inputs.n_callbacks = 0;
    for (int i = 0; i < sim->model->n_inputs; i++) {
        if (sim->inputs.source[i].kind != GB_CONSTANT) {
            sim->inputs.moving[sim->inputs.n_moving++] = i;
            sim->inputs.n_callbacks += sim->inputs.source[i].kind == GB_CALLBACK;
        }
    }
    sim->head->changed = 1;
}

int gb_input_table(gb_sim *sim, int input, int kind, int points, const double *x, const double *y, const double *y2,
                   double period) {
    const gb_source source = {kind, points, x, y, y2, period, NULL, NULL};
    for (int i = 0; i < points; i++) {
        const double sum = x[i] + y[i] + (kind == GB_CUBIC && y2 ? y2[i] : 0.0);
        if (!(sum - sum == 0.0) || (i > 0 && x[i] < x[i - 1])) {
            return gb_fail(sim, GB_ERR_NAN_INPUT, input, x[i], y[i]);
        }
    }
    if (points < 1 || (period > 0.0 && x[points - 1] - x[0] > period)) {
        return gb_fail(sim, GB_ERR_NAN_INPUT, input, period, (double)points);
    }
    sim->inputs.source[input] = source;
    list_moving(sim);
    return GB_DONE;
}

void gb_input_callback(gb_sim *sim, int input, gb_input_fn fn, void *user) {
    const gb_source source = {GB_CALLBACK, 0, NULL, NULL, NULL, 0.0, fn, user};
    sim->inputs.source[input] = source;
    list_moving(sim);
}
