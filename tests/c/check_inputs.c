/* Inputs, and numbers that are none. */
#include "checks.h"

static const double zero[1] = {0.0};

static gb_sim *open_input(const gb_options *options, int kind, int points, const double *x, const double *y,
                          double period) {
    gb_sim *sim = gb_open(&input_model);
    CHECK(gb_input_table(sim, 0, kind, points, x, y, NULL, period) == GB_DONE, "table");
    CHECK(gb_start(sim, options, 0.0, NULL) == GB_DONE, "start");
    return sim;
}

/* A pulse of 1 ms in 10 s of rest is neither skipped nor smeared. */
static void check_pulse(int method) {
    const gb_options options = options_of(method, 1e-6, 0.0);
    const double x[4] = {0.0, 4.0, 4.001, 5.0}, y[4] = {0.0, 3.0, 0.0, 0.0};
    double state[16];
    gb_sim *sim = open_input(&options, GB_STEP, 4, x, y, 0.0);
    CHECK(gb_advance(sim, 3.999) == GB_DONE && gb_state(sim, state) == GB_DONE && state[0] == 0.0, "before");
    CHECK(gb_advance(sim, 10.0) == GB_DONE && gb_state(sim, state) == GB_DONE, "after");
    CHECK(fabs(state[0] - 0.003) < 1e-14, "integral %.17g", state[0]);
    gb_close(sim);
}

/* A triangle wave: linear pieces are integrated without error; before the first point the wave goes on too. */
static void check_periodic(void) {
    const gb_options options = options_of(GB_DP8, 1e-6, 0.0);
    const double x[2] = {0.25, 0.75}, y[2] = {1.0, -1.0};
    double state[16];
    gb_sim *sim = open_input(&options, GB_LINEAR, 2, x, y, 1.0);
    gb_advance(sim, 7.5);
    gb_state(sim, state);
    CHECK(fabs(state[0] - 0.25) < 1e-13, "integral %.17g", state[0]);
    gb_close(sim);
}

static void check_held(void) {
    const gb_options options = options_of(GB_DP5, 1e-6, 0.0);
    const double x[3] = {1.0, 2.0, 2.0}, y[3] = {1.0, 3.0, 5.0};
    double state[16];
    gb_sim *sim = open_input(&options, GB_LINEAR, 3, x, y, 0.0);
    gb_advance(sim, 3.0);
    gb_state(sim, state);
    CHECK(fabs(state[0] - (1.0 + 2.0 + 5.0)) < 1e-13, "integral %.17g", state[0]);
    gb_close(sim);
}

/* A cubic spline through t^3 is t^3. */
static void check_cubic(void) {
    const gb_options options = options_of(GB_DP8, 1e-6, 0.0);
    const double x[4] = {0.0, 0.5, 1.5, 2.0};
    double y[4], y2[4], state[16];
    for (int i = 0; i < 4; i++) {
        y[i] = x[i] * x[i] * x[i];
        y2[i] = 6.0 * x[i];
    }
    gb_sim *sim = gb_open(&input_model);
    CHECK(gb_input_table(sim, 0, GB_CUBIC, 4, x, y, y2, 0.0) == GB_DONE, "table");
    gb_start(sim, &options, 0.0, NULL);
    gb_advance(sim, 1.75);
    gb_state(sim, state);
    CHECK(fabs(state[0] - 0.25 * pow(1.75, 4.0)) < 1e-13, "integral %.17g", state[0]);
    gb_close(sim);
}

static void check_bad_table(void) {
    const double x[3] = {0.0, 2.0, 1.0}, y[3] = {0.0, NAN, 0.0};
    gb_sim *sim = gb_open(&input_model);
    CHECK(gb_input_table(sim, 0, GB_LINEAR, 2, x, y, NULL, 0.0) == GB_ERR_NAN_INPUT, "a value that is none");
    CHECK(gb_input_table(sim, 0, GB_LINEAR, 3, x, x, NULL, 0.0) == GB_ERR_NAN_INPUT, "times that fall");
    gb_close(sim);
}

static int ramp_then_nan(void *user, int index, double t, double *value) {
    (void)user, (void)index;
    *value = t < 0.7 ? t : NAN;
    return t > 5.0;
}

static int stop_at_once(void *user, int index, double t, double *value) {
    (void)user, (void)index;
    *value = t;
    return t > 0.5;
}

static void check_callback(gb_input_fn fn, int expected) {
    const gb_options options = options_of(GB_DP8, 1e-6, 0.1);
    double state[16];
    gb_report report;
    gb_sim *sim = gb_open(&input_model);
    gb_input_callback(sim, 0, fn, NULL);
    CHECK(gb_start(sim, &options, 0.0, NULL) == GB_DONE, "start");
    CHECK(gb_advance(sim, 1.0) == expected, "advance");
    gb_get_report(sim, &report);
    CHECK(report.code == expected && report.index == 0 && report.t > 0.5 && report.t <= 0.8, "report at %g", report.t);
    CHECK(gb_state(sim, state) == expected && gb_time(sim) > 0.45, "time %g", gb_time(sim));
    CHECK(fabs(state[0] - 0.5 * gb_time(sim) * gb_time(sim)) < 1e-12, "state %g", state[0]);
    gb_close(sim);
}

static void check_not_a_number(void) {
    const gb_options options = options_of(GB_DP8, 1e-6, 0.0);
    double bad[3] = {4.2e4, NAN, 2600.0}, y0[16] = {0.0, 0.0, 0.0, 0.0, HUGE_VAL};
    gb_report report;
    int code;
    gb_sim *sim = open_model(&p1_model, bad, &options, &code);
    gb_get_report(sim, &report);
    CHECK(code == GB_ERR_NAN_START && report.index == p1_model.n + 1, "code %d index %d", code, report.index);
    memcpy(gb_parameters(sim), p1_values, sizeof p1_values);
    CHECK(gb_start(sim, &options, 0.0, y0) == GB_ERR_NAN_START, "a start value");
    gb_get_report(sim, &report);
    CHECK(report.index == 4, "index %d", report.index);
    CHECK(gb_advance(sim, 1.0) == GB_ERR_NAN_START, "a run that has not started");
    gb_close(sim);
    sim = open_model(&input_model, zero, &options, &code);
    gb_advance(sim, 0.5);
    gb_inputs(sim)[0] = NAN;
    gb_changed(sim);
    CHECK(gb_advance(sim, 1.0) == GB_ERR_NAN_INPUT, "an input during the run");
    gb_get_report(sim, &report);
    CHECK(report.index == 0 && report.t == 0.5 && gb_time(sim) == 0.5, "at t = %g", report.t);
    gb_close(sim);
}

/* Zero inputs change nothing, and a constant may be changed while running. */
static void check_constant(void) {
    const gb_options options = options_of(GB_DP8, 1e-6, 0.0);
    double state[16];
    int code;
    gb_sim *sim = open_model(&input_model, zero, &options, &code);
    gb_advance(sim, 0.5);
    gb_inputs(sim)[0] = 2.0;
    gb_changed(sim);
    gb_advance(sim, 1.25);
    gb_state(sim, state);
    CHECK(fabs(state[0] - 1.5) < 1e-14, "state %.17g", state[0]);
    gb_close(sim);
}

void check_inputs(void) {
    check_pulse(GB_DP8);
    check_pulse(GB_DP5);
    check_pulse(GB_RK4);
    check_periodic();
    check_held();
    check_cubic();
    check_bad_table();
    check_callback(ramp_then_nan, GB_ERR_NAN_INPUT);
    check_callback(stop_at_once, GB_ERR_CALLBACK);
    check_not_a_number();
    check_constant();
}
