#include "gb_force_split.h"

/* A split with lossy gears along their sides forward and backward, two numbers each. is_own: the motion tells it. */
static void gb_split_once(const gb_lcp *problem, const int *is_own, const double *b, const gb_force_bounds *bounds,
                          const int *sides, double *x) {
    const int n = problem->A.n;
    double lo[n + 1], hi[n + 1], lo_slope[n + 1], hi_slope[n + 1];
    int on[n + 1];
    for (int i = 0; i < n; i++) {
        on[i] = -1;
        lo[i] = is_own[i] ? -HUGE_VAL : bounds->lower[i];
        hi[i] = is_own[i] ? HUGE_VAL : fmax(bounds->lower[i], bounds->upper[i]);
        if (problem->in[i] && gb_split_is_loss(bounds, i) && !is_own[i]) {
            const gb_loss_line forward = gb_loss_on_side(bounds->losses + 5 * (long)i, sides[2 * i]),
                               backward = gb_loss_on_side(bounds->losses + 5 * (long)i, sides[2 * i + 1]);
            on[i] = bounds->tie_of[i];
            lo[i] = -forward.fixed;
            lo_slope[i] = -forward.slope;
            hi[i] = backward.fixed;
            hi_slope[i] = -backward.slope;
        }
    }
    const gb_coupled_bounds coupled = {on, lo_slope, hi_slope};
    gb_lcp once = *problem;
    once.coupled = bounds->tie_of ? &coupled : NULL;
    gb_lcp_solve(&once, b, lo, hi, x);
}

/* The same, with the sides of the forces that come out: Newton steps, all lossy gears at once, later one alone. Where
 * the motion tells the force of a tie, its sides are those of it: a split that would move it is none. */
static void gb_split_by_sides(const gb_lcp *problem, const int *is_own, const double *b, const gb_force_bounds *bounds,
                              const double *force, double *x) {
    const int n = problem->A.n;
    int sides[2 * n + 1], wrong = 1;
    for (int i = 0; i < n && bounds->tie_of; i++) {
        const double tie = gb_split_is_loss(bounds, i) ? force[bounds->tie_of[i]] : 0.0;
        sides[2 * i] = gb_loss_side(bounds->losses + 5 * (long)i, tie);
        sides[2 * i + 1] = gb_loss_side(bounds->losses + 5 * (long)i, -tie);
    }
    for (int round = 0; wrong && round < 4 + n; round++) {
        double largest = 0.0;
        gb_split_once(problem, is_own, b, bounds, sides, x);
        for (int i = 0; i < n; i++) {
            largest = fmax(largest, fabs(x[i]));
        }
        wrong = 0;
        for (int i = 0; i < n && (round < 4 || !wrong); i++) {
            const double *of = bounds->losses + 5 * (long)i;
            if (problem->in[i] && gb_split_is_loss(bounds, i) && !is_own[i] && !is_own[bounds->tie_of[i]] &&
                !gb_loss_agrees(of, sides[2 * i], sides[2 * i + 1], x[bounds->tie_of[i]], x[i], 1e-12 * largest)) {
                sides[2 * i] = gb_loss_side(of, x[bounds->tie_of[i]]);
                sides[2 * i + 1] = gb_loss_side(of, -x[bounds->tie_of[i]]);
                wrong = 1;
            }
        }
    }
}

void gb_split(const gb_delassus *W, gb_active_set *a, const int *is_active, const gb_force_bounds *bounds,
              double *force, double *violation) {
    const int n = W->n;
    const gb_lcp problem = {*W, is_active, NULL, a->room};
    double b[n + 1], x[n + 1], worst = 0.0, size = 0.0, ignored = 0.0;
    int is_own[n + 1];
    for (int i = 0; i < n; i++) {
        is_own[i] = a->redundant[i] == 0.0;
        b[i] = is_active[i] ? -gb_delassus_product(W, i, force, &ignored) : 0.0;
    }
    gb_split_by_sides(&problem, is_own, b, bounds, force, x);
    for (int i = 0; i < n; i++) {
        double terms = fabs(b[i]);
        const double left = is_active[i] ? b[i] + gb_delassus_product(W, i, x, &terms) : 0.0;
        worst = fmax(worst, is_own[i] ? 0.0 : fabs(left));
        size = is_active[i] ? fmax(size, terms) : size;
        if (is_active[i] && !is_own[i] && fabs(bounds->upper[i]) < HUGE_VAL) { /* what nothing loads has this scale */
            size = fmax(size, fabs(gb_delassus_diagonal(W, i) * bounds->upper[i]));
        }
    }
    for (int i = 0; i < n; i++) { /* coupled bounds keep what is lifted */
        force[i] = is_active[i] ? x[i] : force[i];
        violation[i] = worst - (bounds->tie_of ? 1e-8 : 1e-11) * size - DBL_MIN;
    }
}
