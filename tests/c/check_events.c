/* Located switches. */
#include "checks.h"

/* Loose steps see every crossing that small steps see. */
static void check_double_crossings(int method, double rtol) {
    enum { ROWS = 20000 };
    gb_options fine = options_of(GB_DP8, 1e-11, 0.0);
    fine.max_step = 1e-6;
    run loose = run_steps(&p1_model, p1_values, options_of(method, rtol, 0.0), 0.02, ROWS);
    run small = run_steps(&p1_model, p1_values, fine, 0.02, 2 * ROWS);
    const long n = small.record.n_events;
    double worst = 0.0;
    CHECK(loose.code == GB_DONE && small.code == GB_DONE, "codes %d %d", loose.code, small.code);
    CHECK(loose.record.n_events == n && n > 500, "%ld events, %ld with small steps", loose.record.n_events, n);
    for (long i = 0; i < n && i < loose.record.n_events; i++) {
        const gb_event *a = &loose.record.events[i], *b = &small.record.events[i];
        worst = fmax(worst, fabs(a->t - b->t));
        CHECK(a->after == b->after && a->before == b->before, "event %ld", i);
    }
    printf("  crossings of method %d at rtol %.0e: %ld, instants within %.1e s\n", method, rtol, n, worst);
    CHECK(worst < 1e-6, "instants differ by %g", worst);
    free_run(&loose);
    free_run(&small);
}

/* At the start exactly on a limit: the mode follows the motion, and that is no event. */
static void check_start_on_limit(double speed, double mode_expected) {
    const gb_options options = options_of(GB_DP8, 1e-9, 0.0);
    double y0[16] = {1.0, speed}, rows[4 * 18];
    gb_event events[8];
    gb_record record = {rows, 0, 4, events, 0, 8, NULL, NULL};
    const double t[2] = {0.0, 0.01};
    gb_sim *sim = gb_open(&p2_model);
    memcpy(gb_parameters(sim), p2_values, sizeof p2_values);
    CHECK(gb_start(sim, &options, 0.0, y0) == GB_DONE, "start");
    CHECK(gb_run(sim, t, 2, 0.0, &record, 0.0) == GB_DONE, "run");
    CHECK(rows[17] == mode_expected && rows[35] == mode_expected, "modes %g %g", rows[17], rows[35]);
    CHECK(record.n_events == 0, "%ld events", record.n_events);
    gb_close(sim);
}

/* A run that ends at the very instant of an event has both sides of it. */
static void check_event_at_end(void) {
    run r = run_steps(&p2_model, p2_values, options_of(GB_DP8, 1e-9, 0.0), 50.0, 4000);
    const gb_event event = r.record.events[3];
    run again = run_steps(&p2_model, p2_values, options_of(GB_DP8, 1e-9, 0.0), event.t, 4000);
    const double *last = again.record.rows + (again.record.n_rows - 2) * 18;
    CHECK(again.record.n_events == 4, "%ld events", again.record.n_events);
    CHECK(last[0] == event.t && last[18] == event.t, "rows at %g %g, event at %g", last[0], last[18], event.t);
    CHECK(last[17] == event.before && last[35] == event.after, "modes %g %g", last[17], last[35]);
    const double sample[1] = {event.t};
    run right = run_samples(&p2_model, p2_values, options_of(GB_DP8, 1e-9, 0.0), sample, 1);
    CHECK(right.record.rows[17] == event.after, "a sample at an event is its right limit");
    free_run(&r);
    free_run(&again);
    free_run(&right);
}

static void check_chatter(void) {
    const double start[1] = {0.5};
    run r = run_steps(&relay_model, start, options_of(GB_DP8, 1e-6, 0.0), 2.0, 400);
    gb_report report;
    gb_get_report(r.sim, &report);
    CHECK(r.code == GB_ERR_CHATTER && report.index == 0, "code %d", r.code);
    CHECK(fabs(report.t - 0.5) < 1e-9, "at t = %.17g", report.t);
    CHECK(r.record.n_rows > 1 && r.record.rows[0] == 0.0, "rows before it are kept");
    free_run(&r);
}

static void check_time_switch(double step) {
    const double start[1] = {0.0};
    double t[31];
    grid(t, 31, 3.0);
    run r = run_samples(&wave_model, start, options_of(GB_DP8, 1e-6, step), t, 31);
    CHECK(r.code == GB_DONE && r.record.n_events == 10, "code %d, %ld events", r.code, r.record.n_events);
    for (long i = 0; i < r.record.n_rows; i++) {
        const double phase = t[i] - 0.6 * floor(t[i] / 0.6 + 1e-12);
        const double y = phase <= 0.3 ? -phase : phase - 0.6;
        CHECK(fabs(r.record.rows[i * 18 + 1] - y) < 1e-13, "y(%g) = %g, not %g", t[i], r.record.rows[i * 18 + 1], y);
    }
    free_run(&r);
}

/* Each pass of cos t through +-sqrt(level) is found; the level may be so high that a pair lies inside one step. */
static void check_general_event_function(double level, double rtol) {
    const double values[2] = {1.0, level}, at = acos(sqrt(level));
    run r = run_steps(&ring_model, values, options_of(GB_DP8, rtol, 0.0), 20.0, 4000);
    CHECK(r.code == GB_DONE, "code %d", r.code);
    CHECK(r.record.n_events == 13 - (20.0 < 6.0 * 3.14159265358979 + at), "%ld events", r.record.n_events);
    for (long i = 0; i < r.record.n_events; i++) {
        const double expected = (double)((i + 1) / 2) * 3.14159265358979312 + (i % 2 == 0 ? at : -at);
        CHECK(fabs(r.record.events[i].t - expected) < 1e3 * rtol, "event %ld at %.12g, not %.12g", i,
              r.record.events[i].t, expected);
    }
    free_run(&r);
}

/* Without location every stage has the modes of its own state: near the truth, not on it. */
static void check_without_location(void) {
    double t[21];
    grid(t, 21, 20.0);
    gb_options options = options_of(GB_RK4, 1e-6, 0.01);
    run located = run_samples(&p2_model, p2_values, options, t, 21);
    options.locate = 0;
    run free_of_it = run_samples(&p2_model, p2_values, options, t, 21);
    const double error = largest_error(&free_of_it, &located, 0);
    CHECK(free_of_it.code == GB_DONE && error > 1e-12 && error < 1e-2, "error %g", error);
    CHECK(free_of_it.record.n_events == located.record.n_events, "%ld events", free_of_it.record.n_events);
    free_run(&located);
    free_run(&free_of_it);
}

void check_events(void) {
    check_double_crossings(GB_DP8, 1e-4);
    check_double_crossings(GB_DP5, 1e-4);
    check_double_crossings(GB_RK4, 1e-5);
    check_start_on_limit(0.1, 1.0);
    check_start_on_limit(-0.1, 0.0);
    check_event_at_end();
    check_chatter();
    check_time_switch(0.0);
    check_time_switch(0.07);
    check_general_event_function(0.5, 1e-9);
    check_general_event_function(0.9999, 1e-6);
    check_without_location();
}
