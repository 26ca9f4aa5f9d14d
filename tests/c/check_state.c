/* Saved states, communication points, inputs, and what is refused. */
#include "checks.h"

#include "gb_internal.h"

static const double *advance_all(gb_sim *sim, const double *t, long from, long to, double *y) {
    for (long i = from; i < to; i++) {
        CHECK(gb_advance(sim, t[i]) == GB_DONE, "advance to %g", t[i]);
    }
    gb_state(sim, y);
    return y;
}

/* Save, run on, restore, run again: equal bits; in another instance too. */
static void check_snapshot(const gb_options *options) {
    double t[201], y[16], again[16], other_y[16];
    int code;
    gb_sim *sim = open_model(&p1_model, p1_values, options, &code), *other = gb_open(&p1_model);
    void *block = malloc(gb_snapshot_size(sim));
    gb_stats stats, stats_again;
    grid(t, 201, 0.003);
    advance_all(sim, t, 0, 77, y);
    gb_save(sim, block);
    advance_all(sim, t, 77, 201, y);
    gb_get_stats(sim, &stats);
    CHECK(gb_restore(sim, block) == GB_DONE && gb_restore(other, block) == GB_DONE, "restore");
    CHECK(gb_time(other) == t[76], "time %g", gb_time(other));
    advance_all(sim, t, 77, 201, again);
    advance_all(other, t, 77, 201, other_y);
    gb_get_stats(sim, &stats_again);
    CHECK(memcmp(y, again, sizeof y) == 0 && memcmp(y, other_y, sizeof y) == 0, "bits differ");
    CHECK(memcmp(&stats, &stats_again, sizeof stats) == 0, "counters differ");
    gb_sim *stranger = gb_open(&p2_model);
    CHECK(gb_restore(stranger, block) == GB_ERR_STATE, "the state of another model");
    free(block);
    gb_close(sim);
    gb_close(other);
    gb_close(stranger);
}

/* Blocks with a sound checksum and a head that no run has: what chooses from tables is looked at too. */
static void check_forged(void) {
    const gb_options options = options_of(GB_DP8, 1e-8, 0.0);
    int code;
    gb_sim *sim = open_model(&p1_model, p1_values, &options, &code);
    const size_t size = gb_snapshot_size(sim), at = offsetof(gb_head, checksum), after = at + sizeof(uint64_t);
    char *block = malloc(size);
    gb_head head;
    CHECK(gb_advance(sim, 0.001) == GB_DONE, "advance");
    for (int i = 0; i < 9; i++) {
        gb_save(sim, block);
        memcpy(&head, block, sizeof head);
        switch (i) {
        case 0:
            head.method = GB_METHODS;
            break;
        case 1:
            head.options.method = -1;
            break;
        case 2:
            head.choice.explicit_method = 17;
            break;
        case 3:
            head.front.t_comm = head.front.t1 + 1.0;
            break;
        case 4:
            head.front.t1 = HUGE_VAL;
            break;
        case 5:
            head.control.h_next = NAN;
            break;
        case 6:
            head.options.rtol = 0.0;
            break;
        case 7:
            head.front.sample = -1;
            break;
        default: /* as it was */
            break;
        }
        memcpy(block, &head, sizeof head);
        const uint64_t own = gb_checksum(block + after, size - after, gb_checksum(block, at, 0));
        memcpy(block + at, &own, sizeof own);
        CHECK(gb_restore(sim, block) == (i < 8 ? GB_ERR_STATE : GB_DONE), "forged block %d", i);
        CHECK(gb_fits(sim, block) == (i == 8), "forged block %d fits", i);
    }
    free(block);
    gb_close(sim);
}

/* Communication points do not disturb the steps: the values are those of one run through the same samples. */
static void check_communication(double step, double t_end) {
    const gb_options options = options_of(GB_DP8, 1e-8, 0.0);
    const long n = (long)floor(t_end / step + 1e-9) + 1;
    double *t = malloc(sizeof(double) * (size_t)n), y[16];
    int code, differ = 0;
    for (long i = 0; i < n; i++) {
        t[i] = step * (double)i;
    }
    run r = run_samples(&p1_model, p1_values, options, t, n);
    gb_sim *sim = open_model(&p1_model, p1_values, &options, &code);
    CHECK(r.code == GB_DONE && r.record.n_rows == n, "code %d", r.code);
    for (long i = 0; i < n; i++) {
        gb_advance(sim, t[i]);
        gb_state(sim, y);
        differ += memcmp(y, r.record.rows + i * 18 + 1, sizeof y) != 0;
    }
    CHECK(differ == 0, "%d of %ld points differ at a step of %g", differ, n, step);
    free(t);
    free_run(&r);
    gb_close(sim);
}

/* A record of few rows, emptied again and again, gives the same rows. */
static void check_small_record(void) {
    const gb_options options = options_of(GB_DP8, 1e-6, 0.0);
    run whole = run_steps(&p1_model, p1_values, options, 0.002, 2000);
    double rows[3 * 18];
    gb_event events[2];
    gb_record record = {rows, 0, 3, events, 0, 2, NULL, NULL};
    long at = 0, n_events = 0;
    int code, differ = 0;
    gb_sim *sim = open_model(&p1_model, p1_values, &options, &code);
    do {
        record.n_rows = record.n_events = 0;
        code = gb_run(sim, NULL, 0, 0.002, &record, 1e-9);
        for (long i = 0; i < record.n_rows; i++, at++) {
            differ += memcmp(rows + i * 18, whole.record.rows + at * 18, 18 * sizeof(double)) != 0;
        }
        n_events += record.n_events;
    } while (code == GB_FULL || code == GB_PAUSE);
    CHECK(code == GB_DONE && at == whole.record.n_rows && differ == 0, "code %d, %d of %ld differ", code, differ, at);
    CHECK(n_events == whole.record.n_events, "%ld events", n_events);
    free_run(&whole);
    gb_close(sim);
}

/* A parameter written between two communication points takes effect there, and the step size is kept. */
static void check_change(void) {
    const gb_options options = options_of(GB_DP8, 1e-10, 0.0);
    double y[16], again[16];
    gb_stats before, after;
    int code;
    gb_sim *sim = open_model(&p2_model, p2_values, &options, &code);
    gb_sim *fresh = open_model(&p2_model, p2_values, &options, &code);
    gb_advance(sim, 10.0);
    gb_get_stats(sim, &before);
    gb_parameters(sim)[1] = 0.1;
    gb_changed(sim);
    gb_state(sim, y);
    CHECK(gb_advance(sim, 20.0) == GB_DONE, "advance");
    gb_get_stats(sim, &after);
    CHECK(after.steps - before.steps < 2 * before.steps, "%lld steps after %lld", after.steps, before.steps);
    gb_parameters(fresh)[1] = 0.1;
    CHECK(gb_start(fresh, &options, 10.0, y) == GB_DONE && gb_advance(fresh, 20.0) == GB_DONE, "fresh start");
    gb_state(sim, y);
    gb_state(fresh, again);
    CHECK(fabs(y[0] - again[0]) < 1e-8, "%.12g and %.12g", y[0], again[0]);
    gb_close(sim);
    gb_close(fresh);
}

static void check_rows_evaluate(void) {
    double t[50], out[100], energy[50 * 7], one[2];
    const int pick[2] = {1, 0};
    int code;
    const gb_options options = options_of(GB_DP8, 1e-8, 0.0);
    grid(t, 50, 0.001);
    run r = run_samples(&p1_model, p1_values, options, t, 50);
    gb_sim *sim = open_model(&p1_model, p1_values, &options, &code);
    CHECK(gb_evaluate(r.sim, r.record.rows, 50, pick, 2, out, energy) == GB_DONE, "evaluate");
    for (int i = 0; i < 50; i++) {
        gb_advance(sim, t[i]);
        gb_outputs(sim, one);
        CHECK(one[1] == out[2 * i] && one[0] == out[2 * i + 1], "row %d", i);
    }
    gb_close(sim);
    free_run(&r);
}

void check_state(void) {
    gb_options options = options_of(GB_DP8, 1e-7, 0.0);
    check_snapshot(&options);
    options = options_of(GB_DP5, 1e-7, 0.0);
    check_snapshot(&options);
    options = options_of(GB_RK4, 1e-7, 1e-6);
    check_snapshot(&options);
    check_forged();
    check_communication(1e-5, 0.01);
    check_communication(1e-3, 0.01);
    check_communication(1.7e-7, 0.001);
    check_communication(3.37e-4, 0.01);
    check_small_record();
    check_change();
    check_rows_evaluate();
}
