/* Tables inside laws: points joined by lines, a spline, held from the left, or polynomials of any degree between
 * joints.
 *
 * The mode of a table is the number of the segment in use: -1 and n - 1 are the held ends, 0 .. n - 2 the segments
 * between; a periodic table counts on (whole periods times n - 1). A segment is continued smoothly past its joints.
 * Knows nothing of what a table describes. */
#ifndef GB_TABLE_H
#define GB_TABLE_H

#include <math.h>

enum { GB_TABLE_LINEAR = 1, GB_TABLE_STEP = 2, GB_TABLE_CUBIC = 3, GB_TABLE_PIECES = 4 };

/* y: values at the joints x and `second` their second derivatives. The kind GB_TABLE_PIECES + degree has polynomials: y
 * holds degree + 1 coefficients per segment, over the local coordinate in [-1, 1], and there is no `second`. */
typedef struct gb_table {
    int kind, n, periodic;
    const double *x, *y, *second;
} gb_table;

/* Number of the segment inside one period, and the shift of its period. */
static inline int gb_table_local(const gb_table *table, double mode, double *shift) {
    *shift = 0.0;
    if (!table->periodic)
        return (int)mode;
    const double turns = floor(mode / (double)(table->n - 1));
    *shift = turns * (table->x[table->n - 1] - table->x[0]);
    return (int)(mode - turns * (double)(table->n - 1));
}

static inline double gb_table_lo(const gb_table *table, double mode) {
    double shift;
    const int i = gb_table_local(table, mode, &shift);
    return i < 0 ? -HUGE_VAL : table->x[i] + shift;
}

/* Of a periodic table to the last digit where the next segment begins. */
static inline double gb_table_hi(const gb_table *table, double mode) {
    double shift;
    if (table->periodic)
        return gb_table_lo(table, mode + 1.0);
    const int i = gb_table_local(table, mode, &shift);
    return i >= table->n - 1 ? HUGE_VAL : table->x[i + 1] + shift;
}

/* The segment that holds s (a joint belongs to the upper one). */
static inline double gb_table_segment(const gb_table *table, double at) {
    const int n = table->n;
    const double *x = table->x;
    double turns = 0.0, s = at;
    if (table->periodic) {
        turns = floor((s - x[0]) / (x[n - 1] - x[0]));
        s -= turns * (x[n - 1] - x[0]);
    }
    int lo = 0, hi = n;
    while (lo < hi) {
        const int mid = (lo + hi) / 2;
        if (x[mid] <= s)
            lo = mid + 1;
        else
            hi = mid;
    }
    int segment = lo - 1;
    if (table->periodic)
        segment = segment < 0 ? 0 : (segment > n - 2 ? n - 2 : segment);
    double mode = turns * (double)(n - 1) + (double)segment;
    if (table->periodic && at >= gb_table_hi(table, mode)) /* the turn taken off above costs the last digit */
        mode += 1.0;
    else if (table->periodic && at < gb_table_lo(table, mode))
        mode -= 1.0;
    return mode;
}

/* Value or derivative of a polynomial segment at the distance a beyond its lower joint. */
static inline double gb_table_piece(const gb_table *table, int i, double a, int order) {
    const int degree = table->kind - GB_TABLE_PIECES;
    const double *c = table->y + i * (degree + 1);
    const double half = 0.5 * (table->x[i + 1] - table->x[i]), v = (a - half) / half;
    double sum = 0.0, scale = 1.0;
    for (int j = degree; j >= order; j--) {
        double factor = c[j];
        for (int k = 0; k < order; k++)
            factor *= (double)(j - k);
        sum = sum * v + factor;
    }
    for (int k = 0; k < order; k++)
        scale *= half;
    return sum / scale;
}

/* Value (order 0) or derivative of the given order on the segment `mode`. */
static inline double gb_table_value(const gb_table *table, double mode, double s, int order) {
    double shift;
    int i = gb_table_local(table, mode, &shift);
    const int n = table->n;
    if (i < 0 || i >= n - 1)
        return order > 0 ? 0.0 : table->y[i < 0 ? 0 : n - 1];
    if (table->kind >= GB_TABLE_PIECES)
        return gb_table_piece(table, i, s - shift - table->x[i], order);
    const double *x = table->x + i, *y = table->y + i, *m = table->second + i;
    if (table->kind == GB_TABLE_STEP)
        return order > 0 ? 0.0 : y[0];
    /* from the nearer joint: both segments there have its value to the last bit, so that what rests on it is not pushed
     * by rounding */
    const double h = x[1] - x[0], slope = (y[1] - y[0]) / h, d = (m[1] - m[0]) / h; /* no curvature when linear */
    const int near = s - shift - x[0] > 0.5 * h;
    const double a = s - shift - x[near];
    const double b = slope + h * (near ? m[0] + 2.0 * m[1] : -(2.0 * m[0] + m[1])) / 6.0;
    if (order == 0)
        return y[near] + a * (b + a * (0.5 * m[near] + a * d / 6.0));
    if (order == 1)
        return b + a * (m[near] + 0.5 * a * d);
    return order == 2 ? m[near] + a * d : (order == 3 ? d : 0.0);
}

/* A table of two variables, lines or splines along both: values z and second derivatives at the points of a grid, row
 * by row over x. Its modes are the segments on both axes (tables without values). */
typedef struct gb_table2 {
    const gb_table *x, *y;
    const double *z, *xx, *yy, *xxyy;
} gb_table2;

/* Value or derivative along y at row i, of a quantity on the grid and its second derivative by y. */
static inline double gb_table2_row(const gb_table2 *table, const double *z, const double *yy, int i, double mode,
                                   double y, int order) {
    const int n = table->y->n;
    const gb_table row = {table->y->kind, n, 0, table->y->x, z + i * n, yy + i * n};
    return gb_table_value(&row, mode, y, order);
}

/* Value or derivative of the given orders by x and y in the cell of both modes. */
static inline double gb_table2_value(const gb_table2 *table, double mode_x, double mode_y, double x, double y, int by_x,
                                     int by_y) {
    const int n = table->x->n, i = (int)mode_x;
    if (i < 0 || i >= n - 1)
        return by_x > 0 ? 0.0 : gb_table2_row(table, table->z, table->yy, i < 0 ? 0 : n - 1, mode_y, y, by_y);
    const double z[2] = {gb_table2_row(table, table->z, table->yy, i, mode_y, y, by_y),
                         gb_table2_row(table, table->z, table->yy, i + 1, mode_y, y, by_y)};
    const double xx[2] = {gb_table2_row(table, table->xx, table->xxyy, i, mode_y, y, by_y),
                          gb_table2_row(table, table->xx, table->xxyy, i + 1, mode_y, y, by_y)};
    const gb_table line = {table->x->kind, 2, 0, table->x->x + i, z, xx};
    return gb_table_value(&line, 0.0, x, by_x);
}

/* Next instant > t at which rate * t + offset leaves segment `mode`; *after: the segment beyond. */
static inline double gb_table_next(const gb_table *table, double rate, double offset, double mode, double t,
                                   double *after) {
    const double edge = rate > 0.0 ? gb_table_hi(table, mode) : gb_table_lo(table, mode);
    const double next = (edge - offset) / rate;
    *after = rate > 0.0 ? mode + 1.0 : mode - 1.0;
    return rate != 0.0 && next > t ? next : HUGE_VAL;
}

#endif
