/* The implicit method: order, ledger, stiffness, events, singular matrices, sparse factors, the choice of the method.
 */
#include "checks.h"

#include "gb_sparse_ldu.h"

enum { SAMPLES = 21, SIZES = 5, LENGTH = 20 };

/* Fixed steps on a nonlinear problem driven by time, at sample times that are no steps: order 5 for the states and a
 * quadrature (entry `quadrature`), a little less between the steps, where the polynomial has order 4. */
static void check_order(const gb_model *model, double value, double largest_step, int quadrature, double expected) {
    double t[SAMPLES], t_last[2] = {0.0, 3.0}, error[3][SIZES];
    grid(t, SAMPLES, 3.0);
    run reference = run_samples(model, &value, options_of(GB_DP8, 1e-14, 0.0), t, SAMPLES);
    run end = run_samples(model, &value, options_of(GB_DP8, 1e-14, 0.0), t_last, 2);
    for (int i = 0; i < SIZES; i++) {
        const double step = largest_step / (1 << i);
        run r = run_samples(model, &value, options_of(GB_RODAS, 1e-6, step), t_last, 2);
        run between = run_samples(model, &value, options_of(GB_RODAS, 1e-6, step * 1.0123), t, SAMPLES);
        CHECK(r.code == GB_DONE && between.code == GB_DONE, "codes %d %d", r.code, between.code);
        error[0][i] = largest_error(&r, &end, 0);
        error[1][i] = largest_error(&r, &end, quadrature);
        error[2][i] = largest_error(&between, &reference, 0);
        printf("  %s: step %.5f errors %.2e quadrature %.2e between %.2e\n", model->name, step, error[0][i],
               error[1][i], error[2][i]);
        free_run(&r);
        free_run(&between);
    }
    for (int what = 0; what < 3; what++) {
        const double order = log2(error[what][SIZES - 3] / error[what][SIZES - 2]);
        printf("  %s: order %.2f\n", model->name, order);
        CHECK(order > (what == 2 ? expected - 1.0 : expected) - 0.3, "order %.2f of %d", order, what);
    }
    free_run(&reference);
    free_run(&end);
}

/* A stiffer spring of the van der Pol oscillator or a weaker damper: the same steps within a factor. */
static void check_stiffness(const gb_model *model, const double *values, int n) {
    long long most = 0, least = 1000000;
    for (int i = 0; i < n; i++) {
        const gb_options options = options_of(GB_RODAS, 1e-6, 0.0);
        gb_stats stats;
        int code;
        gb_sim *sim = open_model(model, &values[i], &options, &code);
        code = gb_advance(sim, 0.5);
        gb_get_stats(sim, &stats);
        printf("  %s with %g: %lld steps, %lld rejected, %lld Jacobians\n", model->name, values[i], stats.steps,
               stats.rejected, stats.jacobians);
        CHECK(code == GB_DONE && stats.jacobians == stats.steps + stats.rejected, "code %d", code);
        most = stats.steps > most ? stats.steps : most;
        least = stats.steps < least ? stats.steps : least;
        gb_close(sim);
    }
    CHECK(most < 4 * least, "%lld to %lld steps", least, most);
}

/* The implicit method meets its tolerance across located corners, the ledger closes, and auto finds it. */
static void check_chain(double swing, double rtol, double allowed) {
    gb_model *model = open_chain(LENGTH);
    const double values[3] = {LENGTH, swing, 1.0};
    double t[SAMPLES];
    grid(t, SAMPLES, 0.05);
    run reference = run_samples(model, values, options_of(GB_DP8, 1e-11, 0.0), t, SAMPLES);
    for (int method = GB_RODAS; method <= GB_AUTO; method++) {
        run r = run_samples(model, values, options_of(method, rtol, 0.0), t, SAMPLES);
        double worst = 0.0;
        gb_stats stats;
        gb_get_stats(r.sim, &stats);
        for (int i = 0; i < LENGTH; i++) {
            worst = fmax(worst, largest_error(&r, &reference, i));
        }
        printf("  chain, swing %g, rtol %.0e, method %d: error %.1e, %lld steps (%lld implicit), %ld corners\n", swing,
               rtol, method, worst, stats.steps, stats.steps_by[GB_RODAS], r.record.n_events);
        CHECK(r.code == GB_DONE && worst < allowed, "code %d, error %g", r.code, worst);
        CHECK(r.record.n_events == reference.record.n_events, "%ld corners", r.record.n_events);
        CHECK(stats.steps_by[GB_RODAS] > (method == GB_RODAS ? stats.steps - 1 : 0), "never implicit");
        free_run(&r);
    }
    free_run(&reference);
    close_chain(model);
}

static void check_ledger(double rtol) {
    const gb_options options = options_of(GB_RODAS, rtol, 0.0);
    const double damping = 0.01;
    double before, after, y[16];
    gb_stats stats;
    int code;
    gb_sim *sim = open_model(&node_model, &damping, &options, &code);
    gb_energies(sim, &before);
    CHECK(gb_advance(sim, 5.0) == GB_DONE, "advance");
    gb_energies(sim, &after);
    gb_state(sim, y);
    gb_get_stats(sim, &stats);
    const double residual = fabs(after - before - y[9] + y[8]) / (stats.turnover + before);
    printf("  ledger of a node at rtol %.0e: residual %.1e\n", rtol, residual);
    CHECK(residual < 10.0 * rtol, "residual %g", residual);
    gb_close(sim);
}

/* Without a damper the node has nothing to go by: the matrix is singular, and says where. */
static void check_singular(void) {
    const gb_options fixed = options_of(GB_RODAS, 1e-6, 0.1), missing = options_of(GB_RODAS, 1e-6, 0.0);
    gb_report report;
    const double values[3] = {0.0, 0.0, 0.0};
    int code;
    gb_sim *sim = open_model(&node_model, values, &fixed, &code);
    code = gb_advance(sim, 1.0);
    CHECK(code < 0, "code %d", code);
    gb_close(sim);
    sim = open_model(&growth_model, values, &missing, &code);
    gb_get_report(sim, &report);
    CHECK(code == GB_ERR_METHOD && report.index == GB_RODAS, "code %d", code);
    gb_close(sim);
}

/* A full 4 x 4 matrix through the kernel with pairs. */
static void check_factors(void) {
    const int order[] = {2, 0, 3, 1}, start[] = {0, 3, 5, 6, 6}, row[] = {1, 2, 3, 2, 3, 3}, pair[] = {3, 4, 5, 5};
    const gb_pattern p = {4, 6, 0, 0, order, start, row, pair};
    double a[4][4], diag[4], lower[6], upper[6], inverse[4], work[4], x[4], b[4] = {0.0};
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            a[i][j] = i == j ? 5.0 + i : 1.0 / (1.0 + i + 2.0 * j);
            b[i] += a[i][j] * (j + 1.0);
        }
        diag[i] = a[i][i];
    }
    for (int k = 0; k < 4; k++) {
        for (int place = start[k]; place < start[k + 1]; place++) {
            lower[place] = a[order[row[place]]][order[k]];
            upper[place] = a[order[k]][order[row[place]]];
        }
    }
    CHECK(gb_factor(&p, NULL, 2.0, diag, lower, upper, inverse) == -1, "singular");
    gb_solve(&p, inverse, lower, upper, b, work, x);
    for (int i = 0; i < 4; i++) {
        CHECK(fabs(x[i] - 2.0 * (i + 1.0)) < 1e-13, "x[%d] = %.17g", i, x[i]);
    }
    diag[2] = 0.0;
    CHECK(gb_factor(&p, NULL, 1.0, diag, lower, upper, inverse) == 2, "the first pivot is zero");
}

/* The same with the unknown of one step `gain` times another one, and one that nothing else reads ahead of them: x
 * follows, and what is left of the equations has no part along such motions. */
static void check_ties(int step, int with, double gain) {
    const int order[] = {4, 2, 0, 3, 1}, start[] = {0, 2, 5, 7, 8, 8}, row[] = {1, 4, 2, 3, 4, 3, 4, 4},
              pair[] = {5, 6, 7, 7};
    const gb_pattern p = {5, 8, 0, 1, order, start, row, pair};
    int place[5];
    const double gains[5] = {gain, gain, gain, gain, gain};
    const gb_ties ties = {place, gains};
    double a[5][5] = {{0.0}}, diag[5], lower[8], upper[8], inverse[5], work[5], x[5], left[5],
           b[5] = {3.0, -1.0, 2.0, 0.5, 4.0};
    for (int k = 0; k < 5; k++) {
        a[order[k]][order[k]] = diag[order[k]] = 5.0 + k;
        place[k] = -1;
        for (int at = start[k]; at < start[k + 1]; at++) {
            a[order[row[at]]][order[k]] = lower[at] = k > 0 ? 1.0 / (2.0 + at) : 0.0;
            a[order[k]][order[row[at]]] = upper[at] = 1.0 - 0.2 * at;
            place[k] = k == step && row[at] == with ? at : place[k];
        }
    }
    CHECK(gb_factor(&p, &ties, 2.0, diag, lower, upper, inverse) == -1, "singular");
    gb_solve(&p, inverse, lower, upper, b, work, x);
    for (int i = 0; i < 5; i++) {
        left[i] = -2.0 * b[i];
        for (int j = 0; j < 5; j++) {
            left[i] += a[i][j] * x[j];
        }
    }
    CHECK(x[order[step]] == gain * x[order[with]], "%g and %g", x[order[step]], x[order[with]]);
    left[order[with]] += gain * left[order[step]];
    for (int i = 0; i < 5; i++) {
        CHECK(i == order[step] || fabs(left[i]) < 1e-13, "equation %d: %g", i, left[i]);
    }
}

/* A tree that is mostly a chain eliminated from both ends, its matrix not symmetric, the order backwards: `leaves` hang
 * on its middle, so that the runs are broken there. */
static void check_runs(int n, int leaves) {
    int order[64], start[65], row[64];
    double diag[64], lower[64], upper[64], inverse[64], work[64], x[64], b[64], l0[64], u0[64];
    const gb_pattern p = {n, n - 1, 1, 0, order, start, row, NULL};
    for (int k = 0; k < n; k++) {
        order[k] = n - 1 - k;
        start[k] = k;
        row[k] = k < leaves ? n / 2 + k % 3 : k + 2 < n ? k + 2 : n - 1;
        l0[k] = lower[k] = 1.0 / (1.0 + k % 5);
        u0[k] = upper[k] = -0.5 - 0.1 * (k % 7);
        diag[order[k]] = 3.0 + k % 4;
    }
    start[n] = n - 1;
    start[n - 1] = n - 1;
    for (int k = 0; k < n; k++) {
        b[order[k]] = diag[order[k]] * (k + 1.0);
    }
    for (int k = 0; k + 1 < n; k++) {
        b[order[row[k]]] += lower[k] * (k + 1.0);
        b[order[k]] += upper[k] * (row[k] + 1.0);
    }
    CHECK(gb_factor(&p, NULL, 2.0, diag, lower, upper, inverse) == -1, "singular");
    gb_solve(&p, inverse, lower, upper, b, work, x);
    for (int k = 0; k < n; k++) {
        CHECK(fabs(x[order[k]] - 2.0 * (k + 1.0)) < 1e-12 * n, "%d of %d: %.17g", k, n, x[order[k]]);
    }
    gb_solve(&p, inverse, lower, upper, b, work, b);
    CHECK(memcmp(b, x, sizeof(double) * (size_t)n) == 0, "not in place");
    for (int k = 0; k + 1 < n; k++) {
        const double pivot = 2.0 / inverse[k];
        CHECK(fabs(lower[k] * pivot - l0[k]) < 1e-14 && fabs(upper[k] * pivot - u0[k]) < 1e-14, "factor %d", k);
    }
}

/* Saved in the middle of a run that changed its method, restored into another: equal bits. */
static void check_snapshot(void) {
    gb_model *model = open_chain(LENGTH);
    const double values[3] = {LENGTH, 1.5, 1.0};
    const gb_options options = options_of(GB_AUTO, 1e-5, 0.0);
    double *y = malloc(sizeof(double) * (size_t)model->n_total),
           *again = malloc(sizeof(double) * (size_t)model->n_total);
    int code;
    gb_sim *sim = open_model(model, values, &options, &code), *other = gb_open(model);
    void *block = malloc(gb_snapshot_size(sim));
    CHECK(gb_advance(sim, 0.0203) == GB_DONE, "advance");
    gb_save(sim, block);
    CHECK(gb_advance(sim, 0.04) == GB_DONE && gb_restore(other, block) == GB_DONE, "restore");
    CHECK(gb_advance(other, 0.04) == GB_DONE, "advance");
    gb_state(sim, y);
    gb_state(other, again);
    CHECK(memcmp(y, again, sizeof(double) * (size_t)model->n_total) == 0, "bits differ");
    free(y);
    free(again);
    free(block);
    gb_close(sim);
    gb_close(other);
    close_chain(model);
}

void check_stiff(void) {
    const double stiff[] = {1.0, 1e2, 1e4, 1e6}, damping[] = {1e-1, 1e-3, 1e-5, 1e-7};
    check_factors();
    check_ties(1, 2, 1.0);
    check_ties(1, 3, -0.5);
    check_ties(1, 4, 3.0);
    check_ties(2, 3, -2.0);
    check_ties(2, 4, 1.0);
    check_ties(3, 4, 0.25);
    for (int n = 8; n < 64; n++) {
        check_runs(n, n % 4);
    }
    check_order(&pol_model, 1.0, 0.1, 8, 5.0);
    check_order(&pol_model, 30.0, 0.02, 8, 5.0);
    check_order(&node_model, 1.0, 0.1, 8, 5.0);
    check_order(&node_model, 0.05, 0.02, 9, 4.0); /* on the way to stiff: the order is reduced for a while */
    check_stiffness(&pol_model, stiff, 4);
    check_stiffness(&node_model, damping, 4);
    check_ledger(1e-4);
    check_ledger(1e-7);
    check_ledger(1e-10);
    check_chain(0.5, 1e-5, 1e-4);
    check_chain(1.5, 1e-7, 1e-4);
    check_singular();
    check_snapshot();
}
