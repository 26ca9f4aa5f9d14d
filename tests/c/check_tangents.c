/* Tangents against differences of runs. */
#include "checks.h"

#include <math.h>

enum { PERIODS = 6 };

static const double at[4] = {-2.0, -1.0, 1.0, 2.0}, weight[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};

/* The state after the last of the times, and the columns beside it where there are some; change: as of gb_tangents. */
static int follow(const double *values, const double *change, const double *y0, const double *times, double *columns,
                  int count, double *last) {
    const gb_options options = options_of(GB_DP8, 1e-12, 0.0);
    const double scale[2] = {1.0, 1.0};
    double states[PERIODS * 16];
    gb_sim *sim = gb_open(&p2_model);
    memcpy(gb_parameters(sim), values, sizeof p2_values);
    double *room = malloc(sizeof *room * gb_tangent_size(sim, count));
    gb_tangents tangents = {.count = count, .n_times = PERIODS, .times = times, .scale = scale};
    tangents.columns = columns;
    tangents.states = states;
    tangents.room = room;
    tangents.change = change;
    int code = gb_start(sim, &options, 0.0, y0);
    code = code == GB_DONE ? gb_tangents_run(sim, &tangents, 100.0) : code;
    CHECK(code == GB_DONE && tangents.done == PERIODS, "code %d, %ld times", code, tangents.done);
    CHECK(tangents.undefined == 0, "%lld events without a derivative", tangents.undefined);
    memcpy(last, states + (PERIODS - 1) * 16, sizeof *last * 16);
    gb_close(sim);
    free(room);
    return code;
}

static void check_columns(void) {
    const double step = 1e-5;
    double times[PERIODS], start[16] = {0.4, 0.1}, columns[2 * 16] = {1.0}, last[16], none[16] = {0.0};
    columns[16 + 1] = 1.0;
    for (int i = 0; i < PERIODS; i++) {
        times[i] = 3.0 * (i + 1);
    }
    follow(p2_values, NULL, start, times, columns, 2, last);
    for (int j = 0; j < 2; j++) {
        double slope[2] = {0.0, 0.0};
        for (int p = 0; p < 4; p++) {
            double beside[16];
            memcpy(beside, start, sizeof beside);
            beside[j] += at[p] * step;
            follow(p2_values, NULL, beside, times, none, 0, last);
            slope[0] += weight[p] / step * last[0];
            slope[1] += weight[p] / step * last[1];
        }
        for (int i = 0; i < 2; i++) {
            const double off = fabs(columns[16 * j + i] - slope[i]);
            CHECK(off < 1e-6 * fmax(1.0, fabs(slope[i])), "d y%d/d y%d = %g, differences %g", i, j, columns[16 * j + i],
                  slope[i]);
        }
    }
}

/* The last column along one parameter after the other: the gap moves corners, the frequency the drive. */
static void check_parameters(void) {
    const double start[16] = {0.4, 0.1}, step = 1e-5;
    double times[PERIODS], none[16] = {0.0}, last[16];
    for (int i = 0; i < PERIODS; i++) {
        times[i] = 3.0 * (i + 1);
    }
    for (int j = 0; j < 6; j++) {
        double change[6] = {0.0}, columns[2 * 16] = {1.0}, slope[2] = {0.0, 0.0}, by_state[16] = {1.0};
        change[j] = p2_values[j];
        follow(p2_values, change, start, times, columns, 2, last);
        follow(p2_values, NULL, start, times, by_state, 1, last);
        CHECK(columns[0] == by_state[0] && columns[1] == by_state[1], "a parameter changes the column beside it");
        for (int p = 0; p < 4; p++) {
            double values[6];
            memcpy(values, p2_values, sizeof values);
            values[j] += at[p] * step * change[j];
            follow(values, NULL, start, times, none, 0, last);
            slope[0] += weight[p] / step * last[0];
            slope[1] += weight[p] / step * last[1];
        }
        for (int i = 0; i < 2; i++) {
            const double off = fabs(columns[16 + i] - slope[i]);
            CHECK(off < 1e-6 * fmax(1.0, fabs(slope[i])), "d y%d/d parameter %d = %g, differences %g", i, j,
                  columns[16 + i], slope[i]);
        }
    }
}

/* A run that no tangents follow refuses them. */
static void check_refusal(void) {
    gb_options options = options_of(GB_DP8, 1e-9, 0.0);
    const double times[1] = {1.0}, scale[2] = {1.0, 1.0};
    double columns[16] = {1.0}, room[1];
    gb_tangents tangents = {.count = 0, .n_times = 1, .times = times, .scale = scale};
    options.locate = 0;
    gb_sim *sim = gb_open(&p2_model);
    memcpy(gb_parameters(sim), p2_values, sizeof p2_values);
    tangents.columns = columns;
    tangents.room = room;
    CHECK(gb_tangents_run(sim, &tangents, 1.0) == GB_ERR_STATE, "not started");
    CHECK(gb_start(sim, &options, 0.0, NULL) == GB_DONE, "start");
    CHECK(gb_tangents_run(sim, &tangents, 1.0) == GB_ERR_METHOD, "events that are not located");
    options.locate = 1;
    tangents.change = p2_values;
    CHECK(gb_start(sim, &options, 0.0, NULL) == GB_DONE, "start");
    CHECK(gb_tangents_run(sim, &tangents, 1.0) == GB_ERR_STATE, "no column for the parameters");
    gb_close(sim);
}

void check_tangents(void) {
    check_columns();
    check_parameters();
    check_refusal();
}
