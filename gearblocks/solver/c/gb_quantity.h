/* What is kept of outputs along a run (gb_quantity of gb_core.h), on the solution and not on samples of it. On each
 * segment [a, b] between steps and events, f at the five nodes x_i of Gauss and Lobatto:
 *
 *   mean = 1/T sum (b - a) sum w_i f(x_i),   rms^2 = 1/T sum (b - a) sum w_i f(x_i)^2,
 *   std^2 = 1/T sum (b - a) sum w_i (f(x_i) - mean)^2            exact for polynomials of degree 7
 *   peak = max of the polynomial through the nodes, p = sum c_k T_k, k = 0 .. 4
 *
 *
 * and where an estimate of max |f - p| by |c_4| and |c_3| exceeds a hundredth of the tolerance, and p with it the peak
 * so far, that of the polynomial of degree 15 through Chebyshev points of the segment instead. Knows nothing of runs
 * and events. */
#ifndef GB_QUANTITY_H
#define GB_QUANTITY_H

#include "gb_internal.h"

/* Before a run; their kinds and windows stand. */
void gb_quantities_begin(gb_quantities *all);

/* The segment that ends at the front. is_step: the front has come there by a step, else an event has changed what
 * stands at it. */
int gb_quantities_take(gb_sim *sim, gb_quantities *all, int is_step);

/* The value at the end of a run. */
double gb_quantity_value(const gb_quantity *r);

#endif
