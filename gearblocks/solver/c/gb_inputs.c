#include "gb_inputs.h"
#include "gb_report.h"

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
    double value = a * s->y[i] + b * s->y[j];
    if (s->kind == GB_CUBIC && s->y2) {
        value += ((a * a * a - a) * s->y2[i] + (b * b * b - b) * s->y2[j]) * (width * width / 6.0);
    }
    return value;
}

void gb_input_find(gb_sim *sim, double t, int log) {
    for (int m = 0; m < sim->inputs.n_moving; m++) {
        const int i = sim->inputs.moving[m];
        const gb_source *s = &sim->inputs.source[i];
        if (s->kind == GB_CALLBACK) {
            sim->inputs.cell[i] = 0.0;
            sim->inputs.cell_end[i] = HUGE_VAL;
        } else if (!log || sim->inputs.cell_end[i] <= t) {
            const double before = log ? table_value(s, sim->inputs.cell[i], t) : 0.0;
            sim->inputs.cell[i] = cell_of(s, t);
            sim->inputs.cell_end[i] = end_of_cell(s, sim->inputs.cell[i]);
            if (log && s->kind == GB_STEP) {
                gb_log(sim, sim->model->n_switches + i, 1, before, table_value(s, sim->inputs.cell[i], t));
            }
        }
    }
}

static int moving_value(gb_sim *sim, int i, double t, double *value) {
    const gb_source *s = &sim->inputs.source[i];
    *value = 0.0;
    if (s->kind != GB_CALLBACK) {
        *value = table_value(s, sim->inputs.cell[i], t);
    } else if (s->fn(s->user, i, t, value) != 0) {
        return gb_fail(sim, GB_ERR_CALLBACK, i, t, *value);
    }
    return *value - *value == 0.0 ? GB_DONE : gb_fail(sim, GB_ERR_NAN_INPUT, i, t, *value);
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
    sim->inputs.n_moving = 0;
    for (int i = 0; i < sim->model->n_inputs; i++) {
        if (sim->inputs.source[i].kind != GB_CONSTANT) {
            sim->inputs.moving[sim->inputs.n_moving++] = i;
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
