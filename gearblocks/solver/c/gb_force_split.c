#include "gb_force_split.h"
#include "gb_load_limit.h"

/* Most combinations of sides that are looked at for a split. */
enum { GB_SPLITS = 625 };
/* What a split leaves is rounding below this part of its terms. */
static const double GB_ROUNDING = 1e-11;
/* Room that is not asked beyond: hypot(part of the load, all bounds) less all of them but a part. It grows with the
 * load, whatever the bounds: samples of a load that swings far beyond them would all tell the same, and no step would
 * be too long. Round where the load passes zero: a corner there would look as if a step were too long. */
static const double GB_OF_LOAD = 3.0, GB_OF_BOUNDS = 0.05;

/* A split with lossy gears along their sides forward and backward, two numbers each. is_own: the motion tells it.
 * associated: one within the bounds, those of these sides among them, wherever there is one. None is found: no forces,
 * which leave all of the load (what the search ends with may fulfil the equations, far beyond the bounds, or be no
 * number). */
static void gb_split_once(const gb_lcp *problem, const int *is_own, const double *b, const gb_force_bounds *bounds,
                          const int *sides, int associated, double *x) {
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
            const double keep = bounds->shrink ? 1.0 - bounds->shrink[i] : 1.0;
            on[i] = bounds->tie_of[i];
            lo[i] = -keep * forward.fixed;
            lo_slope[i] = -keep * forward.slope;
            hi[i] = keep * backward.fixed;
            hi_slope[i] = -keep * backward.slope;
            if (associated && !is_own[on[i]]) {
                gb_loss_range(bounds->losses + 5 * (long)i, sides[2 * i], sides[2 * i + 1], lo + on[i], hi + on[i]);
            }
        }
    }
    const gb_coupled_bounds coupled = {on, lo_slope, hi_slope, associated};
    gb_lcp once = *problem;
    once.coupled = bounds->tie_of ? &coupled : NULL;
    if (!gb_lcp_solve(&once, b, lo, hi, x)) {
        memset(x, 0, sizeof(double) * (size_t)n);
    }
}

/* Sides of the loss i for a force of its tie. */
static void gb_split_sides_of(const gb_force_bounds *bounds, int i, double tie, int *sides) {
    sides[2 * i] = gb_loss_side(bounds->losses + 5 * (long)i, tie);
    sides[2 * i + 1] = gb_loss_side(bounds->losses + 5 * (long)i, -tie);
}

/* The same, with the sides of the forces that come out: Newton steps, all lossy gears at once, later one alone. Where
 * the motion tells the force of a tie, its sides are those of it: a split that would move it is none. */
static void gb_split_by_sides(const gb_lcp *problem, const int *is_own, const double *b, const gb_force_bounds *bounds,
                              const double *force, double *x) {
    const int n = problem->A.n;
    int sides[2 * n + 1], wrong = 1;
    for (int i = 0; i < n && bounds->tie_of; i++) {
        gb_split_sides_of(bounds, i, gb_split_is_loss(bounds, i) ? force[bounds->tie_of[i]] : 0.0, sides);
    }
    for (int round = 0; wrong && round < 4 + n; round++) {
        double largest = 0.0;
        gb_split_once(problem, is_own, b, bounds, sides, 0, x);
        for (int i = 0; i < n; i++) {
            largest = fmax(largest, fabs(x[i]));
        }
        wrong = 0;
        for (int i = 0; i < n && (round < 4 || !wrong); i++) {
            const double *of = bounds->losses + 5 * (long)i, keep = bounds->shrink ? 1.0 - bounds->shrink[i] : 1.0;
            if (problem->in[i] && gb_split_is_loss(bounds, i) && !is_own[i] && !is_own[bounds->tie_of[i]] &&
                !gb_loss_agrees(of, sides + 2 * i, x[bounds->tie_of[i]], x[i], keep, 1e-12 * largest)) {
                gb_split_sides_of(bounds, i, x[bounds->tie_of[i]], sides);
                wrong = 1;
            }
        }
    }
}

/* By how much the split x leaves slip accelerations that the forces do not have, < 0: by rounding, that of the forces
 * `given` where there are some. Of several splits that fit one or the other is found: what is measured against it would
 * jump from instant to instant. */
static double gb_split_left(const gb_lcp *problem, const int *is_own, const double *b, const gb_force_bounds *bounds,
                            const double *given, const double *x) {
    const int n = problem->A.n, *is_active = problem->in;
    double worst = 0.0, size = 0.0, ignored = 0.0;
    for (int i = 0; i < n; i++) {
        double terms = fabs(b[i]);
        const double left =
            is_active[i] ? b[i] + gb_delassus_product(&problem->A, i, x, given ? &ignored : &terms) : 0.0;
        worst = fmax(worst, is_own[i] ? 0.0 : fabs(left));
        if (is_active[i] && given) {
            ignored = gb_delassus_product(&problem->A, i, given, &terms);
        }
        size = is_active[i] ? fmax(size, terms) : size;
        if (is_active[i] && !is_own[i] && fabs(bounds->upper[i]) < HUGE_VAL) { /* what nothing loads has this scale */
            size = fmax(size, fabs(gb_delassus_diagonal(&problem->A, i) * bounds->upper[i]));
        }
    }
    return worst - GB_ROUNDING * size - DBL_MIN;
}

/* Forces without bounds can circulate among those that take part: two gears side by side press on each other as hard as
 * they like, and their losses would hold any load. Such rows depend on each other: a pivot vanishes (Cholesky). */
static int gb_split_circulates(const gb_lcp *problem, const int *is_own, const gb_force_bounds *bounds) {
    const int n = problem->A.n;
    int at[n + 1], column[n + 1], count = 0;
    double value[n + 1], row[n + 1], *L = problem->room;
    for (int i = 0; i < n; i++) {
        const int bounded = bounds->lower[i] > -HUGE_VAL && bounds->upper[i] < HUGE_VAL;
        if (problem->in[i] && !is_own[i] && !bounded && !gb_split_is_loss(bounds, i)) {
            at[count++] = i;
        }
    }
    for (int k = 0; k < count; k++) {
        memset(row, 0, sizeof row);
        for (int c = gb_delassus_row(&problem->A, at[k], column, value) - 1; c >= 0; c--) {
            row[column[c]] = value[c];
        }
        for (int j = 0; j <= k; j++) {
            double sum = row[at[j]];
            for (int m = 0; m < j; m++) {
                sum -= L[k * n + m] * L[j * n + m];
            }
            if (j == k && !(sum > 1e-9 * row[at[k]])) {
                return 1;
            }
            L[k * n + j] = j == k ? sqrt(sum) : sum / L[j * n + j];
        }
    }
    return 0;
}

/* Where bounds grow with forces the complementarity problem of a split can have a solution that slips beside those that
 * hold: a clutch takes off a gear what would let it hold more. With every combination of sides of the gears at rest
 * whose forces of ties the motion does not tell, the split that leaves least, into x where it leaves less than `left`;
 * returns what is left. Where forces circulate nothing tells how large they are: the split that was found stays. */
static double gb_split_of_any_sides(const gb_lcp *problem, const int *is_own, const double *b,
                                    const gb_force_bounds *bounds, const double *force, const double *given,
                                    double left, double *x) {
    const int n = problem->A.n;
    int sides[2 * n + 1], option[n + 1], more = 1;
    double other[n + 1];
    memset(option, 0, sizeof option);
    memset(sides, 0, sizeof sides);
    if (gb_split_circulates(problem, is_own, bounds)) {
        return left;
    }
    for (int count = 0; more && left > 0.0 && count < GB_SPLITS; count++) {
        more = 0;
        for (int i = 0; i < n; i++) {
            if (!problem->in[i] || !gb_split_is_loss(bounds, i) || is_own[i]) {
                continue;
            }
            if (is_own[bounds->tie_of[i]]) {
                gb_split_sides_of(bounds, i, force[bounds->tie_of[i]], sides);
                continue;
            }
            gb_loss_option(option[i], sides + 2 * i);
            if (!more) { /* the next combination, of which this one is the digit that counts on */
                option[i] = (option[i] + 1) % gb_loss_options(bounds->losses + 5 * (long)i);
                more = option[i] != 0;
            }
        }
        gb_split_once(problem, is_own, b, bounds, sides, 1, other);
        const double now = gb_split_left(problem, is_own, b, bounds, given, other);
        if (now < left) {
            left = now;
            memcpy(x, other, sizeof(double) * (size_t)n);
        }
    }
    return left;
}

/* Of those that take part the least one of each block, which acts on none outside of it: trains beside each other, or
 * parts of one that nothing couples. */
static void blocks_of(const gb_delassus *W, const int *in, int *block) {
    int column[W->n + 1];
    double value[W->n + 1];
    for (int i = 0; i < W->n; i++) {
        block[i] = i;
    }
    for (int more = 1; more;) {
        more = 0;
        for (int i = 0; i < W->n; i++) {
            for (int c = in[i] ? gb_delassus_row(W, i, column, value) - 1 : -1; c >= 0; c--) {
                const int j = column[c];
                if (in[j] && value[c] != 0.0 && block[i] != block[j]) {
                    block[i] = block[j] = block[i] < block[j] ? block[i] : block[j];
                    more = 1;
                }
            }
        }
    }
}

/* The members of a block of those that take part; returns whether there are any. */
static int members_of(int n, const int *in, const int *block, int least, int *member) {
    int any = 0;
    for (int i = 0; i < n; i++) {
        member[i] = in[i] && block[i] == least;
        any = any || member[i];
    }
    return any;
}

void gb_split_at_rest(const gb_lcp *problem, const double *b, const gb_force_bounds *bounds, double *force) {
    const int n = problem->A.n;
    int is_own[n + 1], block[n + 1], member[n + 1];
    double split[n + 1];
    gb_lcp one = *problem;
    one.in = member;
    memset(is_own, 0, sizeof is_own);
    blocks_of(&problem->A, problem->in, block);
    for (int least = 0; least < n; least++) {
        if (members_of(n, problem->in, block, least, member)) {
            memcpy(split, force, sizeof(double) * (size_t)n);
            gb_split_of_any_sides(&one, is_own, b, bounds, force, NULL, HUGE_VAL, split);
            for (int i = 0; i < n; i++) {
                force[i] = member[i] ? split[i] : force[i];
            }
        }
    }
}

/* The largest slip acceleration against which forces that the motion does not tell hold; x: room. */
static double gb_split_load(const gb_lcp *problem, const int *is_own, const double *force, double *x) {
    const int n = problem->A.n;
    double load = 0.0, ignored = 0.0;
    for (int i = 0; i < n; i++) {
        x[i] = is_own[i] ? 0.0 : force[i];
    }
    for (int i = 0; i < n; i++) {
        load = problem->in[i] && !is_own[i] ? fmax(load, fabs(gb_delassus_product(&problem->A, i, x, &ignored))) : load;
    }
    return load;
}

/* Up to which factor of the load it is asked whether it is held: its room grows with the load, whatever the bounds. */
static double gb_split_far(const gb_lcp *problem, const int *is_own, const gb_force_bounds *bounds, double load) {
    double most = 0.0;
    for (int i = 0; i < problem->A.n; i++) {
        const double upper = problem->in[i] && !is_own[i] ? fabs(bounds->upper[i]) : 0.0;
        most += upper < HUGE_VAL ? fabs(gb_delassus_diagonal(&problem->A, i)) * upper : 0.0;
    }
    const double enough = most > 0.0 ? hypot(GB_OF_LOAD * load, most) - (1.0 - GB_OF_BOUNDS) * most : load;
    return load > 1e-3 * most ? 1.0 + enough / load : -enough;
}

/* What a split that is found leaves, < 0: by how much the load, as slip acceleration, may grow. Beside lossy gears a
 * search by their sides does not find all that there is; how far the load is from what can be held tells. */
static double gb_split_room(const gb_lcp *problem, const int *is_own, const gb_force_bounds *bounds,
                            const double *force, double left, double *x) {
    const int n = problem->A.n, fits = !(left > 0.0);
    double other[n + 1];
    const double load = gb_split_load(problem, is_own, force, other);
    const double far = gb_split_far(problem, is_own, bounds, load);
    if (fits && far < 0.0) {
        return fmin(left, far);
    }
    if (!fits && (!bounds->tie_of || gb_split_circulates(problem, is_own, bounds))) {
        return left;
    }
    const double factor = gb_load_limit(problem, is_own, bounds, force, fmax(far, 2.0), other);
    const double room = load * ((fits ? fmax(factor, 1.0) : factor) - 1.0);
    if (!fits && factor >= 1.0) {
        for (int i = 0; i < n; i++) {
            x[i] = is_own[i] ? force[i] : other[i];
        }
    }
    return fits ? fmin(left, -room) : -room - GB_ROUNDING * load;
}

/* The split of a block of the active constraints. */
static void split_block(const gb_delassus *W, gb_active_set *a, const int *member, const gb_force_bounds *bounds,
                        double *force, double *violation) {
    const int n = W->n;
    const gb_lcp problem = {*W, member, NULL, a->room, 0, NULL};
    double b[n + 1], x[n + 1], ignored = 0.0;
    int is_own[n + 1];
    for (int i = 0; i < n; i++) {
        is_own[i] = a->redundant[i] == 0.0;
        b[i] = member[i] ? -gb_delassus_product(W, i, force, &ignored) : 0.0;
    }
    gb_split_by_sides(&problem, is_own, b, bounds, force, x);
    const double left =
        gb_split_room(&problem, is_own, bounds, force, gb_split_left(&problem, is_own, b, bounds, force, x), x);
    for (int i = 0; i < n; i++) {
        force[i] = member[i] ? x[i] : force[i];
        violation[i] = member[i] ? left : violation[i];
    }
}

void gb_split(const gb_delassus *W, gb_active_set *a, const int *is_active, const gb_force_bounds *bounds,
              double *force, double *violation) {
    const int n = W->n;
    int block[n + 1], member[n + 1];
    blocks_of(W, is_active, block);
    for (int least = 0; least < n; least++) {
        int redundant = 0;
        if (members_of(n, is_active, block, least, member)) {
            for (int i = 0; i < n; i++) {
                redundant = redundant || (member[i] && a->redundant[i] != 0.0);
            }
        }
        if (redundant) {
            split_block(W, a, member, bounds, force, violation);
        }
    }
}
