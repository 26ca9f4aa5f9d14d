/* Cases that break solvers: rest, noise, tiny scales, simultaneous and touching events. */
#include "checks.h"

#include "gb_internal.h"
#include "gb_progress.h"

static long long steps_of(const gb_sim *sim) {
    gb_stats stats;
    gb_get_stats(sim, &stats);
    return stats.steps;
}

/* Equilibrium up to rounding, and rest in the middle of the gap: few steps, no growth. */
static void check_rest(double force, double x, double allowed) {
    const double values[6] = {0.05, 0.0, force, 0.0, 0.9, 1.0};
    const gb_options options = options_of(GB_DP8, 1e-9, 0.0);
    double y0[16] = {x}, y[16];
    gb_sim *sim = gb_open(&p2_model);
    memcpy(gb_parameters(sim), values, sizeof values);
    CHECK(gb_start(sim, &options, 0.0, y0) == GB_DONE, "start");
    CHECK(gb_advance(sim, 1000.0) == GB_DONE, "advance");
    gb_state(sim, y);
    CHECK(fabs(y[0] - x) < 1e-12 && fabs(y[1]) < 1e-12, "moved to %g, %g", y[0] - x, y[1]);
    CHECK((double)steps_of(sim) < allowed, "%lld steps", steps_of(sim));
    printf("  rest at %g: %lld steps\n", x, steps_of(sim));
    gb_close(sim);
}

/* Lengths and forces times a factor: the same steps, the same motion. */
static void check_scale(double factor) {
    const double values[6] = {0.05, 0.2, 0.1 * factor, 0.05 * factor, 0.9, factor};
    const gb_options options = options_of(GB_DP8, 1e-8, 0.0);
    double y0[16] = {1.1 * factor}, y[16], expected[16];
    int code;
    gb_sim *sim = gb_open(&p2_model), *plain = open_model(&p2_model, p2_values, &options, &code);
    memcpy(gb_parameters(sim), values, sizeof values);
    gb_start(sim, &options, 0.0, y0);
    gb_advance(plain, 50.0);
    CHECK(gb_advance(sim, 50.0) == GB_DONE, "advance at scale %g", factor);
    gb_state(sim, y);
    gb_state(plain, expected);
    CHECK(fabs(y[0] / factor - expected[0]) < 1e-6, "%g, not %g", y[0] / factor, expected[0]);
    CHECK(llabs(steps_of(sim) - steps_of(plain)) < steps_of(plain) / 4, "%lld and %lld steps", steps_of(sim),
          steps_of(plain));
    gb_close(sim);
    gb_close(plain);
}

/* From nothing at all, the size of the states is found on the way. */
static void check_zero_start(void) {
    const gb_options options = options_of(GB_DP8, 1e-8, 0.0), fine = options_of(GB_DP8, 1e-12, 0.0);
    double y0[16] = {0.0}, y[16], expected[16];
    gb_sim *sim = gb_open(&p2_model), *reference = gb_open(&p2_model);
    memcpy(gb_parameters(sim), p2_values, sizeof p2_values);
    memcpy(gb_parameters(reference), p2_values, sizeof p2_values);
    gb_start(sim, &options, 0.0, y0);
    gb_start(reference, &fine, 0.0, y0);
    CHECK(gb_advance(sim, 30.0) == GB_DONE && gb_advance(reference, 30.0) == GB_DONE, "advance");
    gb_state(sim, y);
    gb_state(reference, expected);
    CHECK(fabs(y[0] - expected[0]) < 1e-6, "%g, not %g", y[0], expected[0]);
    CHECK(steps_of(sim) < 400, "%lld steps", steps_of(sim));
    gb_close(sim);
    gb_close(reference);
}

/* A train that spins fast as a whole: its twists are as before, and the steps are no smaller for the rounding. */
static void check_spin(void) {
    const gb_options options = options_of(GB_DP8, 1e-9, 0.0);
    double y0[16], y[16], expected[16];
    int code;
    gb_sim *sim = gb_open(&p1_model), *still = open_model(&p1_model, p1_values, &options, &code);
    memcpy(gb_parameters(sim), p1_values, sizeof p1_values);
    gb_state(still, y0);
    for (int i = 3; i < 7; i++) {
        y0[i] = 300.0;
    }
    gb_start(sim, &options, 0.0, y0);
    gb_advance(still, 0.005);
    CHECK(gb_advance(sim, 0.005) == GB_DONE, "advance");
    gb_state(sim, y);
    gb_state(still, expected);
    for (int i = 0; i < 3; i++) {
        CHECK(fabs(y[i] - expected[i]) < 1e-6 * fabs(expected[i]) + 1e-9, "twist %d: %g, not %g", i, y[i], expected[i]);
    }
    CHECK(steps_of(sim) < 2 * steps_of(still), "%lld and %lld steps", steps_of(sim), steps_of(still));
    gb_close(sim);
    gb_close(still);
}

/* Eight equal oscillators flip at one instant, each once, and stay equal. */
static void check_simultaneous(void) {
    const double start[1] = {1.1};
    gb_options options = options_of(GB_DP8, 1e-9, 0.0);
    double t[2] = {0.0, 40.0};
    run r = run_samples(&eight_model, start, options, t, 2);
    const double *y = r.record.rows + row_length(&eight_model) + 1;
    CHECK(r.code == GB_DONE && r.record.n_events > 0 && r.record.n_events % 8 == 0, "code %d, %ld events", r.code,
          r.record.n_events);
    for (long i = 0; i + 7 < r.record.n_events; i += 8) {
        CHECK(r.record.events[i].t == r.record.events[i + 7].t, "events %ld", i);
    }
    for (int i = 1; i < 8; i++) {
        CHECK(y[i] == y[0] && y[8 + i] == y[8], "oscillator %d", i);
    }
    free_run(&r);
}

/* x^2 - 1 is touched from below by x = cos t and never crossed: at most a pair of flips at one instant. */
static void check_grazing(double level) {
    const double values[2] = {0.0, level};
    const gb_options options = options_of(GB_DP8, 1e-10, 0.0);
    double y0[16] = {0.0, 1.0}, y[16];
    gb_sim *sim = gb_open(&ring_model);
    memcpy(gb_parameters(sim), values, sizeof values);
    CHECK(gb_start(sim, &options, 0.0, y0) == GB_DONE, "start");
    CHECK(gb_advance(sim, 20.0) == GB_DONE, "advance");
    gb_state(sim, y);
    CHECK(fabs(y[8] + 20.0) < 1e-3, "integral of the mode %g", y[8]);
    gb_close(sim);
}

/* The largest step and the stop time are kept. */
static void check_limits(void) {
    gb_options options = options_of(GB_DP5, 1e-3, 0.0);
    gb_stats stats;
    int code;
    options.max_step = 0.01;
    options.t_stop = 1.0;
    gb_sim *sim = open_model(&p2_model, p2_values, &options, &code);
    gb_advance(sim, 0.999);
    gb_get_stats(sim, &stats);
    CHECK(stats.steps >= 100 && stats.t <= 1.0, "%lld steps to %g", stats.steps, stats.t);
    gb_close(sim);
}

/* A solution that ends: the run stops there, says so, and keeps what it has. */
static void check_growth(int method, double step) {
    const double start[1] = {1.0};
    run r = run_steps(&growth_model, start, options_of(method, 1e-6, step), 2.0, 4000);
    gb_report report;
    gb_get_report(r.sim, &report);
    const double *last = r.record.rows + (r.record.n_rows - 1) * (long)row_length(&growth_model);
    CHECK(r.code == GB_ERR_STEP || r.code == GB_ERR_NAN_RATE ||
              r.code == (step > 0.0 ? GB_ERR_UNSTABLE : GB_ERR_ESCAPE),
          "code %d", r.code);
    CHECK(report.index == 0 && fabs(report.t - 1.0) < (step > 0.0 ? 1.0 : 1e-4), "at t = %.9g", report.t);
    CHECK(r.record.n_rows > 2 && last[1] > 1.0 && last[1] < HUGE_VAL, "last row at %g", last[0]);
    free_run(&r);
}

/* So many refused tries in a row that hardly bring the run on end it, by the state with the largest error or by the
 * event function that was in doubt; where they bring it on they are left alone. */
static void check_stall(void) {
    const gb_options options = options_of(GB_DP8, 1e-8, 0.0);
    gb_report report;
    int code;
    for (int in_doubt = 0; in_doubt < 2; in_doubt++) {
        gb_sim *sim = open_model(&p2_model, p2_values, &options, &code);
        CHECK(gb_advance(sim, 1.0) == GB_DONE, "advance");
        const double t = sim->head->front.t1;
        sim->head->counts.rejected += GB_TRIES - 1;
        CHECK(gb_progress_of_tries(sim, 1e30, in_doubt) == GB_DONE, "too early");
        sim->head->counts.rejected += 1;
        CHECK(gb_progress_of_tries(sim, t + 100.0, in_doubt) == GB_DONE, "it has come from 0 to %g", t);
        sim->head->counts.rejected += GB_TRIES;
        sim->events.undersampled = 0;
        sim->events.in_doubt = 1;
        CHECK(gb_progress_of_tries(sim, t + 100.0, in_doubt) == GB_ERR_STALL, "it has not moved on");
        gb_get_report(sim, &report);
        CHECK(report.t == t && (int)report.value == GB_TRIES, "%g tries at %g", report.value, report.t);
        CHECK(in_doubt ? report.index == p2_model.n : report.index < p2_model.n, "index %d", report.index);
        gb_close(sim);
    }
}

/* The start time is free: the same motion a whole number of periods later, on the grid of that start. */
static void check_late_start(double step) {
    const gb_options options = options_of(GB_DP5, 1e-11, step);
    const double shift = 7.0 * 2.0 * 3.14159265358979312 / p2_values[4];
    double y[16], later[16];
    int code;
    gb_sim *sim = open_model(&p2_model, p2_values, &options, &code);
    gb_advance(sim, 20.0);
    gb_state(sim, y);
    CHECK(gb_start(sim, &options, shift, NULL) == GB_DONE && gb_advance(sim, shift + 20.0) == GB_DONE, "later");
    gb_state(sim, later);
    CHECK(fabs(y[0] - later[0]) < 1e-9, "%.12g and %.12g", y[0], later[0]);
    gb_close(sim);
}

void check_hard(void) {
    check_growth(GB_DP8, 0.0);
    check_growth(GB_DP5, 0.0);
    check_growth(GB_RK4, 0.01);
    check_stall();
    check_late_start(0.0);
    check_late_start(0.01);
    check_rest(0.1, 1.1, 1000.0);
    check_rest(0.0, 0.0, 1000.0);
    check_rest(0.0, 0.5, 1000.0);
    check_scale(1e-9);
    check_scale(1e12);
    check_zero_start();
    check_spin();
    check_simultaneous();
    check_grazing(1.0);
    check_grazing(1.0 + 1e-9);
    check_limits();
}
