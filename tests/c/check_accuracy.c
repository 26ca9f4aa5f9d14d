/* Orders, tolerances, energy. */
#include "checks.h"

#include "gb_math.h"

enum { SAMPLES = 41, SIZES = 6 };

/* Least-squares slope of log error over log step. */
static double slope(const double *step, const double *error, int n) {
    double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
    for (int i = 0; i < n; i++) {
        const double x = log(step[i]), y = log(error[i]);
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/* A fixed-step method keeps its order across located corners: halving the step, errors within 1e-4 .. 1e-11. */
static void check_order(int method, int order, double largest_step, const run *reference, const double *t) {
    double step[SIZES], error[SIZES];
    int n = 0;
    for (int i = 0; i < SIZES; i++) {
        const double size = largest_step * pow(0.75, i);
        run r = run_samples(&p2_model, p2_values, options_of(method, 1e-6, size), t, SAMPLES);
        const double e = largest_error(&r, reference, 0);
        CHECK(r.code == GB_DONE, "code %d", r.code);
        printf("  order %d: step %.4f error %.2e\n", order, size, e);
        if (e < 1e-4 && e > 1e-11) {
            step[n] = size;
            error[n++] = e;
        }
        free_run(&r);
    }
    CHECK(n >= 4, "only %d errors in the range", n);
    CHECK(slope(step, error, n) >= order - 0.3, "slope %.2f for order %d", slope(step, error, n), order);
    printf("  order %d: slope %.2f\n", order, slope(step, error, n));
}

static void check_tolerance(int method, double best, const run *reference, const double *t) {
    double tolerance[10], error[10];
    int n = 0;
    for (double rtol = 1e-3; rtol > 0.9 * best; rtol *= 0.1) {
        run r = run_samples(&p2_model, p2_values, options_of(method, rtol, 0.0), t, SAMPLES);
        tolerance[n] = rtol;
        error[n] = largest_error(&r, reference, 0);
        CHECK(r.code == GB_DONE && error[n] <= 50.0 * rtol, "rtol %g gives error %g", rtol, error[n]);
        printf("  method %d: rtol %.0e error %.2e\n", method, rtol, error[n]);
        n++;
        free_run(&r);
    }
    CHECK(slope(tolerance, error, n) > 0.8, "errors fall as rtol^%.2f", slope(tolerance, error, n));
}

/* What went in, less what was lost, is what is stored. */
static void check_ledger(const gb_model *model, const double *values, double t_end, double rtol) {
    const gb_options options = options_of(GB_DP8, rtol, 0.0);
    double before[16], after[16], y[16], exchanged = 0.0, stored = 0.0, most = 0.0;
    gb_stats stats;
    int code;
    gb_sim *sim = open_model(model, values, &options, &code);
    gb_energies(sim, before);
    CHECK(gb_advance(sim, t_end) == GB_DONE, "advance");
    gb_energies(sim, after);
    gb_state(sim, y);
    gb_get_stats(sim, &stats);
    for (int i = 0; i < model->n_energies; i++) {
        stored += after[i] - before[i];
        most += fmax(before[i], after[i]);
    }
    for (int i = 0; i < model->n_quadratures; i++) {
        const int is_loss = model == &p1_model ? i < 3 : i < 1;
        exchanged += is_loss ? -y[8 + i] : y[8 + i];
    }
    const double residual = fabs(stored - exchanged) / (stats.turnover + most);
    printf("  ledger of %s at rtol %.0e: residual %.1e of the turnover\n", model->name, rtol, residual);
    CHECK(residual <= 10.0 * rtol, "residual %g at rtol %g", residual, rtol);
    gb_close(sim);
}

void check_accuracy(void) {
    double t[SAMPLES];
    grid(t, SAMPLES, 50.0);
    run reference = run_samples(&p2_model, p2_values, options_of(GB_DP8, 1e-13, 0.0), t, SAMPLES);
    run second = run_samples(&p2_model, p2_values, options_of(GB_DP5, 3e-13, 0.0), t, SAMPLES);
    CHECK(largest_error(&second, &reference, 0) < 1e-11, "%g", largest_error(&second, &reference, 0));
    CHECK(reference.record.n_events >= 10, "%ld events", reference.record.n_events);
    check_order(GB_RK4, 4, 0.08, &reference, t);
    check_order(GB_DP5, 5, 0.16, &reference, t);
    check_order(GB_DP8, 8, 0.7, &reference, t);
    check_tolerance(GB_DP8, 1e-12, &reference, t);
    check_tolerance(GB_DP5, 1e-12, &reference, t);
    check_tolerance(GB_RK4, 1e-10, &reference, t);
    free_run(&reference);
    free_run(&second);
    for (double rtol = 1e-3; rtol > 1e-11; rtol *= 0.1) {
        check_ledger(&p1_model, p1_values, 0.01, rtol);
        check_ledger(&p2_model, p2_values, 50.0, rtol);
    }
}

/* Error in units of the last place of the true value. */
static double ulps(double got, long double true_value) {
    const double rounded = (double)true_value, ulp = nextafter(fabs(rounded), HUGE_VAL) - fabs(rounded);
    return (double)(fabsl((long double)got - true_value) / (long double)ulp);
}

void check_math(void) {
    double x[GB_LANES], in_lanes[GB_LANES], worst = 0.0;
    int differ = 0;
    unsigned long long seed = 1;
    for (int i = 0; i < 50000; i++) {
        for (int l = 0; l < GB_LANES; l++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            const double unit = (double)(seed >> 11) / 9007199254740992.0 - 0.5;
            x[l] = i % 3 == 0 ? 20.0 * unit : i % 3 == 1 ? 2e6 * unit : floor(1e6 * unit) * 0.78539816339744831;
        }
        for (int l = 0; l < GB_LANES; l++) {
            in_lanes[l] = gb_cos(x[l]) + gb_sin(x[l]);
        }
        for (int l = 0; l < GB_LANES; l++) {
            volatile double one = x[l];
            const double c = gb_cos(one), s = gb_sin(one);
            differ += c + s != in_lanes[l];
            worst = fmax(worst, fmax(ulps(c, cosl((long double)x[l])), ulps(s, sinl((long double)x[l]))));
        }
    }
    printf("  sine and cosine: %.3f ulp\n", worst);
    CHECK(worst < 1.0, "%g ulp", worst);
    CHECK(differ == 0, "%d values differ between lanes and scalars", differ);
    worst = 0.0;
    for (int i = 0; i < 40000; i++) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        const double unit = (double)(seed >> 11) / 9007199254740992.0 - 0.5,
                     one = i % 2 ? 8.0 * unit : exp(60.0 * unit);
        worst = fmax(worst, ulps(gb_atan(one), atanl((long double)one)));
    }
    printf("  arc tangent: %.3f ulp\n", worst);
    CHECK(worst < 2.0, "%g ulp", worst);
    CHECK(gb_atan(HUGE_VAL) == acos(0.0) && gb_atan(-HUGE_VAL) == -acos(0.0) && isnan(gb_atan(NAN)), "at infinity");
    CHECK(gb_sin(0.0) == 0.0 && gb_cos(0.0) == 1.0, "at zero");
    CHECK(isnan(gb_cos(HUGE_VAL)) && isnan(gb_sin(-HUGE_VAL)), "at infinity");
}
