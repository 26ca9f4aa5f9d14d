#include "gb_quantity.h"
#include "gb_record.h"
#include "gb_vector.h"

enum { NODES = 5, POINTS = 16, GRID = 33, ROUNDS = 8 };
static const double NODE[NODES] = {0.0, 0.17267316464601142810, 0.5, 0.82732683535398857190, 1.0};
static const double WEIGHT[NODES] = {1.0 / 20.0, 49.0 / 180.0, 16.0 / 45.0, 49.0 / 180.0, 1.0 / 20.0};

/* cos(m pi / 15), m = 0 .. 15. */
static const double COSINE[POINTS] = {
    1.0,  0.97814760073380563793,  0.91354545764260089550,  0.80901699437494742410,  0.66913060635885821383,
    0.5,  0.30901699437494742410,  0.10452846326765347140,  -0.10452846326765347140, -0.30901699437494742410,
    -0.5, -0.66913060635885821383, -0.80901699437494742410, -0.91354545764260089550, -0.97814760073380563793,
    -1.0,
};

static const double PART = 1e-2;      /* of the tolerance of the run: an error of a peak that is no concern */
static const double ROUNDING = 1e-14; /* of the size of an output: a higher peak is none */
static const double STEEP = 25.0;     /* the slope of T_5, what f - p begins with, goes no higher */

/* Behind the rows of a look: the outputs at the nodes of a segment, row by row, then those of one output. */
static double *nodes_of(const gb_sim *sim, const gb_quantities *all) {
    return all->room + (size_t)POINTS * gb_row_length(sim->model);
}

static double *points_of(const gb_sim *sim, const gb_quantities *all) {
    return nodes_of(sim, all) + (size_t)NODES * (size_t)all->count;
}

static double *factors_of(const gb_sim *sim, const gb_quantities *all) {
    return points_of(sim, all) + POINTS;
}

size_t gb_quantity_room(const gb_sim *sim, int count) {
    return (size_t)POINTS * gb_row_length(sim->model) + (size_t)NODES * (size_t)count + 2 * POINTS;
}

void gb_quantities_begin(gb_quantities *all) {
    all->follows = 0;
    for (int j = 0; j < all->count; j++) {
        gb_quantity *r = &all->of[j];
        r->value = -HUGE_VAL;
        r->sum = r->rest = r->scale = r->length = 0.0;
    }
}

/* Outputs of quantities first .. first + n - 1 at instants t[0 .. count) of the segment, f[instant * n + output]. */
static int look(gb_sim *sim, const gb_quantities *all, const double *t, int count, int first, int n, double *f) {
    const size_t length = gb_row_length(sim->model);
    double *factor = factors_of(sim, all);
    for (int i = 0; i < count; i++) {
        const int code = gb_write_row(sim, t[i], all->room + (size_t)i * length);
        if (code != GB_DONE) {
            return code;
        }
    }
    int code = gb_evaluate(sim, all->room, count, all->output + first, n, f, NULL);
    for (int j = 0; j < n && code == GB_DONE; j++) {
        if (all->factor[first + j] >= 0) {
            code = gb_evaluate(sim, all->room, count, all->factor + first + j, 1, factor, NULL);
            for (int i = 0; i < count; i++) {
                f[i * n + j] *= factor[i];
            }
        }
    }
    return code;
}

static void nodes_between(double a, double b, double t[NODES]) {
    const int roomy = a + (b - a) * NODE[1] > a;
    for (int i = 1; i < NODES - 1; i++) {
        t[i] = roomy ? a + (b - a) * NODE[i] : b;
    }
    t[0] = a;
    t[NODES - 1] = b;
}

/* All of them at the nodes of the whole segment; what they are at its begin is known where it follows on the last one.
 */
static int look_at_segment(gb_sim *sim, gb_quantities *all, double t0, double t1) {
    const size_t n = (size_t)all->count;
    double *f = nodes_of(sim, all), t[NODES];
    const int first = all->follows;
    nodes_between(t0, t1, t);
    if (first) {
        memcpy(f, f + (NODES - 1) * n, sizeof(double) * n);
    }
    return look(sim, all, t + first, NODES - first, 0, all->count, f + (size_t)first * n);
}

/* Neumaier's sum. */
static void add(gb_quantity *r, double x) {
    const double sum = r->sum + x;
    r->rest += fabs(r->sum) >= fabs(x) ? (r->sum - sum) + x : (x - sum) + r->sum;
    r->sum = sum;
}

static void integrate(gb_quantity *r, double h, const double f[NODES]) {
    double sum = 0.0;
    for (int i = 0; i < NODES; i++) {
        sum += WEIGHT[i] * f[i];
    }
    add(r, h * sum);
    r->length += h;
}

/* The scale becomes a power of 2 that no value exceeds, so that no square leaves the range of doubles and no digit
 * depends on it: by what share of it the old one counts. */
static double rescaled(gb_quantity *r, const double f[NODES]) {
    double size = 0.0, part = 1.0;
    for (int i = 0; i < NODES; i++) {
        size = gb_max(size, fabs(f[i]));
    }
    if (size > r->scale) {
        int exponent;
        frexp(size, &exponent);
        const double scale = ldexp(1.0, exponent < DBL_MAX_EXP ? exponent : DBL_MAX_EXP - 1);
        part = r->scale / scale;
        r->scale = scale;
    }
    return part;
}

/* Squares in units of the scale. */
static void integrate_square(gb_quantity *r, double h, const double f[NODES]) {
    const double part = rescaled(r, f);
    double sum = 0.0;
    r->sum *= part * part;
    r->rest *= part * part;
    const double unit = r->scale > 0.0 ? 1.0 / r->scale : 0.0;
    for (int i = 0; i < NODES; i++) {
        sum += WEIGHT[i] * ((unit * f[i]) * (unit * f[i]));
    }
    add(r, h * sum);
    r->length += h;
}

/* Segments are merged by their means and their squares about them (Chan, Golub and LeVeque 1983, eq. 1.5), which does
 * not cancel. sum: integral of the squares about the mean; rest: the mean; both in units of the scale. */
static void integrate_deviation(gb_quantity *r, double h, const double f[NODES]) {
    const double part = rescaled(r, f);
    double mean = 0.0, sum = 0.0;
    r->sum *= part * part;
    r->rest *= part;
    const double unit = r->scale > 0.0 ? 1.0 / r->scale : 0.0;
    for (int i = 0; i < NODES; i++) {
        mean += WEIGHT[i] * (unit * f[i]);
    }
    for (int i = 0; i < NODES; i++) {
        sum += WEIGHT[i] * (unit * f[i] - mean) * (unit * f[i] - mean);
    }
    const double length = r->length + h, apart = mean - r->rest;
    r->sum += h * sum + apart * apart * (r->length * (h / length));
    r->rest += apart * (h / length);
    r->length = length;
}

/* sum c_k T_k(x), k = 0 .. n - 1 (Clenshaw). */
static double series(const double *c, int n, double x) {
    double one = 0.0, two = 0.0;
    for (int k = n - 1; k > 0; k--) {
        const double next = c[k] + 2.0 * x * one - two;
        two = one;
        one = next;
    }
    return c[0] + x * one - two;
}

/* Coefficients of the derivative; returns how many. */
static int derivative(const double *c, int n, double *d) {
    for (int k = n - 2; k >= 0; k--) {
        d[k] = 2.0 * (k + 1) * c[k + 1] + (k + 2 < n - 1 ? d[k + 2] : 0.0);
    }
    d[0] *= 0.5;
    return n - 1;
}

static double on_grid(int i) {
    return -1.0 + 2.0 * i / (GRID - 1);
}

/* The largest value of a series on [-1, 1]: Newton's method on its slope from the tops of a grid. */
static double largest(const double *c, int n) {
    double f[GRID], first[POINTS], second[POINTS], best = -HUGE_VAL, least = HUGE_VAL;
    const int n_first = derivative(c, n, first), n_second = derivative(first, n_first, second);
    for (int i = 0; i < GRID; i++) {
        f[i] = series(c, n, on_grid(i));
        best = gb_max(best, f[i]);
        least = gb_min(least, f[i]);
    }
    const double near = best - 0.02 * (best - least);
    for (int i = 0; i < GRID; i++) {
        const int before = i > 0 ? i - 1 : 0, after = i < GRID - 1 ? i + 1 : i;
        if (f[i] < near || f[i] < f[before] || f[i] < f[after]) {
            continue;
        }
        double x = on_grid(i);
        for (int round = 0; round < ROUNDS; round++) {
            const double bend = series(second, n_second, x);
            const double change = bend < 0.0 ? series(first, n_first, x) / bend : 0.0;
            x = gb_min(gb_max(x - change, on_grid(before)), on_grid(after));
            if (fabs(change) < 1e-9) {
                break;
            }
        }
        best = gb_max(best, series(c, n, x));
    }
    return best;
}

/* The polynomial through the nodes: its even and its odd part through those at 0, s and 1, s^2 = 3/7. */
static void series_through_nodes(const double f[NODES], double c[NODES]) {
    const double u = 3.0 / 7.0, s = 0.65465367070797714380;
    const double e1 = 0.5 * (f[3] + f[1]) - f[2], e2 = 0.5 * (f[4] + f[0]) - f[2];
    const double o1 = 0.5 * (f[3] - f[1]), o2 = 0.5 * (f[4] - f[0]);
    const double a4 = (e1 / u - e2) / (u - 1.0), a2 = e2 - a4, b3 = (o1 / s - o2) / (u - 1.0), b1 = o2 - b3;
    c[0] = f[2] + 0.5 * a2 + 0.375 * a4;
    c[1] = b1 + 0.75 * b3;
    c[2] = 0.5 * a2 + 0.5 * a4;
    c[3] = 0.25 * b3;
    c[4] = 0.125 * a4;
}

static void series_through_points(const double f[POINTS], double c[POINTS]) {
    const int n = POINTS - 1;
    for (int k = 0; k <= n; k++) {
        double sum = 0.5 * (f[n] + (k % 2 ? -f[0] : f[0]));
        for (int i = 1; i < n; i++) {
            const int m = (n - i) * k % (2 * n);
            sum += f[i] * COSINE[m <= n ? m : 2 * n - m];
        }
        c[k] = (k == 0 || k == n ? 1.0 : 2.0) / n * sum;
    }
}

/* An estimate of max |f - p|. Where f is odd about its middle, c_4 says nothing: then c_3 does, sixteen times over. */
static double how_unsure(const double c[NODES]) {
    return gb_max(fabs(c[4]), fabs(c[3]) / 16.0);
}

/* Whether f rises to the right end of the segment or falls from the left one wherever it may exceed `known`: then none
 * of its values between does. Each point of the grid stands for half a cell to both sides. */
static int is_steep(const double c[NODES], double known) {
    double slope[NODES];
    const int n = derivative(c, NODES, slope);
    const double unsure = how_unsure(c), half = 1.0 / (GRID - 1);
    const double bend = 4.0 * fabs(c[2]) + 24.0 * fabs(c[3]) + 80.0 * fabs(c[4]);
    for (int i = 0; i < GRID; i++) {
        const double x = on_grid(i), d = series(slope, n, x), rise = half * (fabs(d) + 0.5 * half * bend);
        const double to_end = x > 0.0 ? d : -d;
        if (series(c, NODES, x) + rise + 2.0 * unsure > known && !(to_end > STEEP * unsure + half * bend)) {
            return 0;
        }
    }
    return 1;
}

/* A higher peak in the segment [a, b], where sign f has the values g at the nodes. */
static int heighten(gb_sim *sim, const gb_quantities *all, int j, double a, double b, const double g[NODES]) {
    gb_quantity *r = &all->of[j];
    const double sign = r->kind == GB_PEAK ? 1.0 : -1.0;
    double c[POINTS], reach = 0.0, t[POINTS], *f = points_of(sim, all);
    for (int i = 0; i < NODES; i++) {
        r->value = gb_max(r->value, g[i]);
        r->scale = gb_max(r->scale, fabs(g[i]));
    }
    series_through_nodes(g, c);
    const double unsure = how_unsure(c), enough = r->value + ROUNDING * r->scale;
    for (int k = 1; k < NODES; k++) {
        reach += fabs(c[k]);
    }
    if (!(c[0] + reach + unsure > enough)) {
        return GB_DONE;
    }
    const double shown = largest(c, NODES);
    if (unsure <= PART * sim->head->options.rtol * r->scale) {
        r->value = gb_max(r->value, shown);
        return GB_DONE;
    }
    if (!(shown + unsure > enough) || is_steep(c, r->value) || b - a <= 1e-12 * fabs(b)) {
        return GB_DONE;
    }
    for (int i = 1; i < POINTS - 1; i++) {
        t[i] = 0.5 * (a + b) - 0.5 * (b - a) * COSINE[i];
    }
    const int code = look(sim, all, t + 1, POINTS - 2, j, 1, f + 1);
    for (int i = 1; i < POINTS - 1; i++) {
        f[i] *= sign;
    }
    f[0] = g[0];
    f[POINTS - 1] = g[NODES - 1];
    series_through_points(f, c);
    r->value = gb_max(r->value, largest(c, POINTS));
    return code;
}

static int take(gb_sim *sim, const gb_quantities *all, int j, double a, double b, const double f[NODES]) {
    gb_quantity *r = &all->of[j];
    double g[NODES], taint = 0.0;
    for (int i = 0; i < NODES; i++) {
        g[i] = r->kind == GB_TROUGH ? -f[i] : f[i];
        taint += 0.0 * f[i];
    }
    if (taint != 0.0 || isnan(r->value)) {
        r->value = NAN;
    } else if (r->kind == GB_MEAN) {
        integrate(r, b - a, f);
    } else if (r->kind == GB_RMS) {
        integrate_square(r, b - a, f);
    } else if (r->kind == GB_STD) {
        integrate_deviation(r, b - a, f);
    } else {
        return heighten(sim, all, j, a, b, g);
    }
    return GB_DONE;
}

int gb_quantities_take(gb_sim *sim, gb_quantities *all, int is_step) {
    const double t0 = sim->head->front.t0, t1 = sim->head->front.t1;
    const size_t n = (size_t)all->count;
    int code = GB_DONE, looked = 0;
    for (int j = 0; j < all->count && is_step && code == GB_DONE; j++) {
        const double a = gb_max(t0, all->of[j].after), b = gb_min(t1, all->of[j].before);
        double f[NODES], t[NODES];
        if (!(a < b)) {
            continue;
        }
        if (a > t0 || b < t1) {
            nodes_between(a, b, t);
            code = look(sim, all, t, NODES, j, 1, f);
        } else {
            code = looked ? GB_DONE : look_at_segment(sim, all, t0, t1);
            looked = 1;
            for (size_t i = 0; i < NODES; i++) {
                f[i] = nodes_of(sim, all)[i * n + (size_t)j];
            }
        }
        code = code == GB_DONE ? take(sim, all, j, a, b, f) : code;
    }
    all->follows = looked && sim->head->options.locate;
    return code;
}

double gb_quantity_value(const gb_quantity *r) {
    if (r->kind == GB_PEAK || r->kind == GB_TROUGH) {
        return isinf(r->value) ? NAN : r->kind == GB_PEAK ? r->value : -r->value;
    }
    const double mean = (r->kind == GB_STD ? r->sum : r->sum + r->rest) / r->length;
    return isnan(r->value) ? NAN : r->kind == GB_MEAN ? mean : r->scale * sqrt(mean);
}
