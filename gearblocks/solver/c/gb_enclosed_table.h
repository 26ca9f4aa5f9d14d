/* Enclosures of tables: on one segment a polynomial about the midpoint of the piece, with its derivatives there,
 *
 *     p(s) in p(m) +- sum |p^(k)(m)| r^k / k!,   |s - m| <= r
 *
 * across segments the hull of those that are touched. Knows nothing of what a table describes. */
#ifndef GB_ENCLOSED_TABLE_H
#define GB_ENCLOSED_TABLE_H

#include "gb_enclosure.h"

enum { GB_TABLE_TOUCHED = 64 }; /* segments of a hull; across more nothing is known */

/* The largest power of a segment. */
static inline int gb_table_degree(const gb_table *table) {
    return table->kind >= GB_TABLE_PIECES ? table->kind - GB_TABLE_PIECES
                                          : (table->kind == GB_TABLE_CUBIC ? 3 : table->kind == GB_TABLE_LINEAR);
}

/* A derivative of the given order on one segment over [lo, hi]. */
static inline gb_interval gb_enclosed_segment(const gb_table *table, double mode, double lo, double hi, int order) {
    const double m = 0.5 * (lo + hi), r = 0.5 * (hi - lo);
    const gb_interval all = {-HUGE_VAL, HUGE_VAL};
    double reach = 0.0, power = 1.0;
    if (!(r < HUGE_VAL)) {
        return all;
    }
    for (int k = 1; order + k <= gb_table_degree(table); k++) {
        power *= r / k;
        reach += fabs(gb_table_value(table, mode, m, order + k)) * power;
    }
    return gb_interval_about(gb_table_value(table, mode, m, order), reach);
}

/* The segment `mode`, continued smoothly past its joints. */
static inline gb_enclosure gb_enclosed_table(const gb_table *table, double mode, gb_enclosure x, int order) {
    return gb_chained(x, gb_enclosed_segment(table, mode, x.lo, x.hi, order),
                      gb_enclosed_segment(table, mode, x.lo, x.hi, order + 1));
}

/* The segments that hold x. */
static inline gb_enclosure gb_enclosed_table_at(const gb_table *table, gb_enclosure x, int order) {
    const gb_interval all = {-HUGE_VAL, HUGE_VAL};
    if (!(fabs(x.lo) < 1e15) || !(fabs(x.hi) < 1e15)) {
        return gb_enclosed(all, all);
    }
    const double first = gb_table_segment(table, x.lo), last = gb_table_segment(table, x.hi);
    const int jumps = table->kind == GB_TABLE_STEP || order > (table->kind == GB_TABLE_LINEAR ? 0 : 1);
    gb_interval value = {HUGE_VAL, -HUGE_VAL}, slope = {HUGE_VAL, -HUGE_VAL};
    if (!(last - first < GB_TABLE_TOUCHED)) {
        return gb_enclosed(all, all);
    }
    for (double mode = first; mode <= last; mode += 1.0) {
        const double lo = fmax(x.lo, gb_table_lo(table, mode)), hi = fmin(x.hi, gb_table_hi(table, mode));
        value = gb_interval_hull(value, gb_enclosed_segment(table, mode, lo, fmax(lo, hi), order));
        slope = gb_interval_hull(slope, gb_enclosed_segment(table, mode, lo, fmax(lo, hi), order + 1));
    }
    return gb_chained(x, value, jumps && last > first ? all : slope);
}

/* A derivative of the given orders on one cell over a box. */
static inline gb_interval gb_enclosed_cell(const gb_table2 *table, double mode_x, double mode_y, gb_interval x,
                                           gb_interval y, int by_x, int by_y) {
    const double mx = 0.5 * (x.lo + x.hi), my = 0.5 * (y.lo + y.hi), rx = 0.5 * (x.hi - x.lo), ry = 0.5 * (y.hi - y.lo);
    const int degree = 3; /* lines have no higher derivatives */
    const gb_interval all = {-HUGE_VAL, HUGE_VAL};
    double reach = 0.0, power_x = 1.0;
    if (!(rx < HUGE_VAL) || !(ry < HUGE_VAL)) {
        return all;
    }
    for (int i = 0; by_x + i <= degree; i++) {
        power_x *= i > 0 ? rx / i : 1.0;
        double power_y = 1.0;
        for (int j = 0; by_y + j <= degree; j++) {
            power_y *= j > 0 ? ry / j : 1.0;
            reach += i + j > 0
                         ? fabs(gb_table2_value(table, mode_x, mode_y, mx, my, by_x + i, by_y + j)) * power_x * power_y
                         : 0.0;
        }
    }
    return gb_interval_about(gb_table2_value(table, mode_x, mode_y, mx, my, by_x, by_y), reach);
}

static inline gb_enclosure gb_enclosed_table2(const gb_table2 *table, double mode_x, double mode_y, gb_enclosure x,
                                              gb_enclosure y, int by_x, int by_y) {
    const gb_interval at_x = gb_value_of(x), at_y = gb_value_of(y);
    const gb_interval slope_x = gb_enclosed_cell(table, mode_x, mode_y, at_x, at_y, by_x + 1, by_y);
    const gb_interval slope_y = gb_enclosed_cell(table, mode_x, mode_y, at_x, at_y, by_x, by_y + 1);
    return gb_enclosed(
        gb_enclosed_cell(table, mode_x, mode_y, at_x, at_y, by_x, by_y),
        gb_interval_add(gb_interval_mul(slope_x, gb_rate_of(x)), gb_interval_mul(slope_y, gb_rate_of(y))));
}

#endif
