/* Box-constrained linear complementarity problem:  find lo <= x <= hi with  y = A x + b,
 *     y_i >= 0 where x_i = lo_i,   y_i <= 0 where x_i = hi_i,   y_i = 0 between.
 * A: principal minors positive (symmetric positive definite: one solution), or positive semidefinite where rows are
 * redundant: y is still unique, of the x about the smallest is taken. Bounds may grow with another unknown that has
 * none (friction in proportion to a force); A with such columns may have no solution, or several. Associated: y is the
 * gradient of x'A x/2 + b'x, least within these bounds, so that y = 0 where any x within them has it. Method: block
 * principal pivoting with a least index rule as a way out of cycles (Judice and Pires 1994); for a singular A proximal
 * steps,  (A + e D) x+ + b - e D x  in place of  A x + b  (Rockafellar 1976); where neither finds one, all sides. A in
 * either form of gb_delassus.h; of its unknowns those take part that are marked, the others are 0. Knows nothing of
 * slips, modes or time. */
#ifndef GB_LCP_H
#define GB_LCP_H

#include "gb_coupled_bounds.h"
#include "gb_delassus.h"
#include "gb_gauss_jordan.h"

#include <float.h>

/* A, the unknowns that take part, their coupled bounds (NULL: there are none), and room for as many numbers as A has.
 * graded: where rows are redundant each unknown counts, as where lossy gears share a load; so with coupled bounds.
 * weight: of the lift, by unknown (gb_lcp_solve). */
typedef struct gb_lcp {
    gb_delassus A;
    const int *in;
    const gb_coupled_bounds *coupled;
    double *room;
    int graded;
    const double *weight;
} gb_lcp;

/* Unknown j is at a bound that pushes unknown i. */
static inline int gb_lcp_pushes(const gb_lcp *lcp, const int *side, int j, int i) {
    return lcp->coupled && lcp->coupled->associated && lcp->in[j] && side[j] && lcp->coupled->on[j] == i;
}

/* Adds the row of unknown i, times a factor, to one over the unknowns inside their bounds, by position[]: what bounds
 * of others take of them comes on top. */
static inline void gb_lcp_add_row(const gb_lcp *lcp, int i, double factor, double lift, const int *side,
                                  const int *position, double *row) {
    int column[lcp->A.n + 1];
    double value[lcp->A.n + 1];
    const int count = gb_delassus_row(&lcp->A, i, column, value);
    for (int k = 0; k < count; k++) {
        const int j = column[k], on = lcp->coupled ? lcp->coupled->on[j] : -1;
        const double a = factor * (value[k] + (j == i ? lift * lcp->weight[i] : 0.0));
        if (lcp->in[j] && !side[j]) {
            row[position[j]] += a;
        } else if (lcp->in[j] && on >= 0 && position[on] >= 0) {
            row[position[on]] += a * gb_lcp_slope(lcp->coupled, j, side[j]);
        }
    }
}

/* The matrix of the unknowns inside their bounds, numbered by inside[], and the solution with row exchanges. */
static inline void gb_lcp_dense(const gb_lcp *lcp, double lift, const int *side, int free, const int *inside,
                                double *x) {
    const int n = lcp->A.n;
    int position[n + 1];
    double right[n + 1];
    memset(lcp->room, 0, sizeof(double) * (size_t)free * (size_t)free);
    for (int i = 0; i < n; i++) {
        position[i] = -1;
    }
    for (int p = 0; p < free; p++) {
        position[inside[p]] = p;
    }
    for (int p = 0; p < free; p++) {
        double *row = lcp->room + (long)p * free;
        right[p] = x[inside[p]];
        gb_lcp_add_row(lcp, inside[p], 1.0, lift, side, position, row);
        for (int j = 0; j < n; j++) {
            if (gb_lcp_pushes(lcp, side, j, inside[p])) {
                const double slope = gb_lcp_slope(lcp->coupled, j, side[j]);
                gb_lcp_add_row(lcp, j, slope, lift, side, position, row);
                right[p] += slope * x[j];
            }
        }
    }
    gb_gauss_jordan(free, free, lcp->room, 1, right);
    for (int p = 0; p < free; p++) {
        x[inside[p]] = right[p];
    }
}

/* The unknowns inside their bounds, from those at a bound. */
static inline void gb_lcp_inside(const gb_lcp *lcp, double lift, const double *b, const int *side, double *x) {
    const int n = lcp->A.n;
    int inside[n + 1], is_inside[n + 1], free = 0;
    double right[n + 1], lifts[n + 1], size = 0.0;
    for (int i = 0; i < n; i++) {
        lifts[i] = lift * lcp->weight[i];
        is_inside[i] = lcp->in[i] && side[i] == 0;
        if (is_inside[i]) {
            inside[free++] = i;
            x[i] = 0.0;
        }
    }
    for (int i = 0; i < n; i++) {
        const int pushes = lcp->coupled && gb_lcp_pushes(lcp, side, i, lcp->coupled->on[i]);
        right[i] = is_inside[i] || pushes ? -b[i] - gb_delassus_product(&lcp->A, i, x, &size) : 0.0;
        right[i] -= pushes ? lift * lcp->weight[i] * x[i] : 0.0;
    }
    if (lcp->A.pattern) {
        gb_delassus_factor(&lcp->A, is_inside, lifts, lcp->room);
        gb_delassus_solve(n, lcp->A.pattern, lcp->room, right);
    } else {
        gb_lcp_dense(lcp, lift, side, free, inside, right);
    }
    for (int i = 0; i < n; i++) {
        x[i] = is_inside[i] ? right[i] : x[i];
    }
    for (int j = 0; j < n && lcp->coupled; j++) {
        const int moves = lcp->in[j] && side[j] && lcp->coupled->on[j] >= 0 && !side[lcp->coupled->on[j]];
        x[j] += moves ? gb_lcp_shift(lcp->coupled, j, side[j], x) : 0.0;
    }
}

/* y_i, or 0 where it is rounding: that of the largest unknown passes into all the others. */
static inline double gb_lcp_left(const gb_lcp *lcp, double lift, const double *b, const double *x, double largest,
                                 int i) {
    const int n = lcp->A.n;
    int column[n + 1];
    const double own = lift * lcp->weight[i];
    double value[n + 1], y = b[i] + own * x[i], size = fabs(b[i]) + own * largest;
    const int count = gb_delassus_row(&lcp->A, i, column, value);
    for (int k = 0; k < count; k++) {
        y += value[k] * x[column[k]];
        size += lcp->in[column[k]] ? fabs(value[k]) * largest : 0.0;
    }
    return fabs(y) > 16.0 * DBL_EPSILON * size ? y : 0.0;
}

/* Where each unknown should be instead, -1, 0 or 1 as `side`; returns how many are elsewhere, the last of them in
 * *last. */
static inline int gb_lcp_misplaced(const gb_lcp *lcp, double lift, const double *b, const double *lo, const double *hi,
                                   const double *x, const int *side, int *want, int *last) {
    const int n = lcp->A.n;
    int bad = 0;
    double largest = 0.0;
    for (int i = 0; i < n; i++) {
        largest = fmax(largest, fabs(x[i]));
    }
    for (int i = 0; i < n; i++) {
        want[i] = side[i];
        if (!lcp->in[i]) {
            continue;
        }
        if (side[i] == 0) {
            const double least = lo[i] + gb_lcp_shift(lcp->coupled, i, -1, x),
                         most = hi[i] + gb_lcp_shift(lcp->coupled, i, 1, x);
            want[i] = x[i] < least ? -1 : x[i] > most;
        } else {
            double y = gb_lcp_left(lcp, lift, b, x, largest, i);
            for (int j = 0; j < n && lcp->coupled && lcp->coupled->associated; j++) {
                y += gb_lcp_pushes(lcp, side, j, i)
                         ? gb_lcp_slope(lcp->coupled, j, side[j]) * gb_lcp_left(lcp, lift, b, x, largest, j)
                         : 0.0;
            }
            want[i] = (side[i] < 0 ? y < 0.0 : y > 0.0) ? 0 : side[i];
        }
        if (want[i] != side[i]) {
            *last = i;
            bad++;
        }
    }
    return bad;
}

/* The solution with the unknowns on these sides. */
static inline void gb_lcp_place(const gb_lcp *lcp, double lift, const double *b, const double *lo, const double *hi,
                                const int *side, double *x) {
    const int n = lcp->A.n;
    for (int i = 0; i < n; i++) {
        x[i] = !lcp->in[i] || side[i] == 0 ? 0.0 : side[i] < 0 ? lo[i] : hi[i];
    }
    for (int i = 0; i < n && lcp->coupled; i++) {
        const int with = lcp->in[i] && side[i] && lcp->coupled->on[i] >= 0 && side[lcp->coupled->on[i]];
        x[i] += with ? gb_lcp_shift(lcp->coupled, i, side[i], x) : 0.0;
    }
    gb_lcp_inside(lcp, lift, b, side, x);
}

/* Sides by the digits of a number; 0: there are not so many. */
static inline int gb_lcp_sides(const gb_lcp *lcp, const double *lo, const double *hi, int number, int *side) {
    for (int i = 0; i < lcp->A.n; i++) {
        if (lcp->in[i] && (lo[i] > -HUGE_VAL || hi[i] < HUGE_VAL)) {
            side[i] = number % 3 == 2 ? 1 : -(number % 3);
            number /= 3;
        }
    }
    return number == 0;
}

/* All sides, one after the other: a matrix with friction in proportion to a force may have a negative minor, where what
 * lies beyond a bound has to go to the other one, which pivoting never tries. 0: none fits. */
enum { GB_LCP_MOST = 729 };
static inline int gb_lcp_try_all(const gb_lcp *lcp, double lift, const double *b, const double *lo, const double *hi,
                                 double *x) {
    const int n = lcp->A.n;
    int side[n + 1], want[n + 1], last = -1;
    memset(side, 0, sizeof side);
    for (int number = 0; number < GB_LCP_MOST && gb_lcp_sides(lcp, lo, hi, number, side); number++) {
        double sum = 0.0;
        gb_lcp_place(lcp, lift, b, lo, hi, side, x);
        for (int i = 0; i < n; i++) {
            sum += x[i];
        }
        if (fabs(sum) < HUGE_VAL && gb_lcp_misplaced(lcp, lift, b, lo, hi, x, side, want, &last) == 0) {
            return 1;
        }
    }
    return 0;
}

/* Block principal pivoting for A + lift diag(weight). All that are misplaced change at once, after ten rounds without
 * fewer of them the last one alone (a least index rule, counted from behind). 0: not found. */
static inline int gb_lcp_pivoting(const gb_lcp *lcp, double lift, const double *b, const double *lo, const double *hi,
                                  double *x) {
    const int n = lcp->A.n;
    int side[n + 1], want[n + 1], fewest = n + 1, patience = 10;
    memset(side, 0, sizeof side);
    for (int round = 0; round < 60 + 20 * n; round++) {
        int last = -1;
        gb_lcp_place(lcp, lift, b, lo, hi, side, x);
        const int bad = gb_lcp_misplaced(lcp, lift, b, lo, hi, x, side, want, &last);
        if (bad == 0) {
            return 1;
        }
        if (bad < fewest) {
            fewest = bad;
            patience = 10;
        } else {
            patience--;
        }
        for (int i = 0; i < n; i++) {
            side[i] = patience > 0 || i == last ? want[i] : side[i];
        }
    }
    return 0;
}

/* One proximal step as a correction of x: what is left of the equations is solved for, so that the rounding of a matrix
 * that is nearly singular does not stay in them; where pivoting finds none, by all sides if asked. 2: by no more than
 * rounding; 0: not found. */
static inline int gb_lcp_correct(const gb_lcp *lcp, double lift, const double *b, const double *lo, const double *hi,
                                 int all, double *x) {
    const int n = lcp->A.n;
    double left[n + 1], least[n + 1], most[n + 1], step[n + 1], size = 0.0;
    memset(left, 0, sizeof left);
    memset(least, 0, sizeof least);
    memset(most, 0, sizeof most);
    for (int i = 0; i < n; i++) {
        if (lcp->in[i]) {
            left[i] = b[i] + gb_delassus_product(&lcp->A, i, x, &size);
            least[i] = lo[i] + gb_lcp_shift(lcp->coupled, i, -1, x) - x[i];
            most[i] = hi[i] + gb_lcp_shift(lcp->coupled, i, 1, x) - x[i];
        }
    }
    if (!gb_lcp_pivoting(lcp, lift, left, least, most, step) &&
        !(all && gb_lcp_try_all(lcp, lift, left, least, most, step))) {
        return 0;
    }
    double moved = 0.0, largest = 0.0;
    for (int i = 0; i < n; i++) {
        x[i] += step[i];
        moved = fmax(moved, fabs(step[i]));
        largest = fmax(largest, fabs(x[i]));
    }
    for (int i = 0; i < n; i++) { /* at a bound means exactly there */
        for (int side = -1; side <= 1 && lcp->in[i]; side += 2) {
            const double fixed = side < 0 ? lo[i] : hi[i], shift = gb_lcp_shift(lcp->coupled, i, side, x);
            const double bound = fixed + shift, rounding = 8.0 * DBL_EPSILON * (fabs(fixed) + fabs(shift));
            const int met = fabs(bound) < HUGE_VAL && fabs(x[i] - bound) <= rounding;
            x[i] = met ? bound : x[i];
        }
    }
    return moved <= 1e-13 * largest ? 2 : 1;
}

/* Weights of the lift, which is by the largest diagonal: returns that. An unknown whose own one is far smaller (a load
 * of its own beside a body that is 1e-8 as heavy) is lifted by no more than FARTHEST of the largest would be. */
static const double GB_LCP_FARTHEST = 1e-5;
static inline double gb_lcp_weights(const gb_lcp *lcp, double *weight) {
    const int n = lcp->A.n;
    double most = 0.0;
    for (int i = 0; i < n; i++) {
        most = lcp->in[i] ? fmax(most, fabs(gb_delassus_diagonal(&lcp->A, i))) : most;
    }
    for (int i = 0; i < n; i++) {
        const double own = lcp->in[i] ? fabs(gb_delassus_diagonal(&lcp->A, i)) : 0.0;
        weight[i] = own > 0.0 && own < GB_LCP_FARTHEST * most ? own / (GB_LCP_FARTHEST * most) : 1.0;
    }
    return most;
}

/* The same for a matrix that may be singular: among the solutions about the smallest x, by steps of a proximal method.
 * The lift of the first is large where each unknown counts, since rounding leaves size/lift of a step along what A does
 * not see; from one to the next there is less left to do, down to 1e-9 of the largest diagonal as without. Beside that,
 * what is 1e-7 of the largest and less takes more steps than the few that do for all others. */
enum { GB_LCP_GRADES = 6, GB_LCP_STEPS = 4, GB_LCP_MOST_STEPS = 60 };
static const double GB_LCP_ENDED = 1e-10;
static inline int gb_lcp_solve(const gb_lcp *given, const double *b, const double *lo, const double *hi, double *x) {
    const int n = given->A.n;
    double right[n + 1], before[n + 1], weight[n + 1], moved = 0.0, largest = 0.0;
    const double most = gb_lcp_weights(given, weight);
    gb_lcp weighted = *given;
    const gb_lcp *lcp = &weighted;
    weighted.weight = weight;
    memset(x, 0, sizeof(double) * (size_t)n);
    const int graded = lcp->graded || lcp->coupled;
    double lift = most > 0.0 ? (graded ? 1e-3 : 1e-9) * most : 1.0;
    for (int round = graded ? -GB_LCP_GRADES : 0;
         round < GB_LCP_STEPS || (!graded && round < GB_LCP_MOST_STEPS && moved > GB_LCP_ENDED * largest); round++) {
        for (int i = 0; i < n; i++) {
            before[i] = x[i];
            right[i] = lcp->in[i] ? b[i] - lift * weight[i] * x[i] : 0.0;
        }
        const int found =
            graded ? gb_lcp_correct(lcp, lift, b, lo, hi, 0, x) : gb_lcp_pivoting(lcp, lift, right, lo, hi, x);
        if (found == 0) { /* with all sides tried the lift stays in the equations, too */
            const int any = gb_lcp_try_all(lcp, 1e-9 * most, b, lo, hi, x);
            int more = any ? GB_LCP_STEPS : 0;
            while (more > 0) {
                more = gb_lcp_correct(lcp, 1e-9 * most, b, lo, hi, 1, x) == 1 ? more - 1 : 0;
            }
            return any;
        }
        if (found != 1) {
            return found;
        }
        lift *= round < 0 && most > 0.0 ? 0.1 : 1.0;
        moved = largest = 0.0;
        for (int i = 0; i < n; i++) {
            moved = fmax(moved, fabs(x[i] - before[i]));
            largest = fmax(largest, fabs(x[i]));
        }
    }
    if (!graded) { /* elimination leaves the rounding of a matrix that is nearly singular in the equations */
        gb_lcp_correct(lcp, lift, b, lo, hi, 0, x);
    }
    return 1;
}

#endif
