/* The polynomial inside a step:  y(t0 + th h) = y0 + th (R1 + (1 - th) (R2 + th (R3 + (1 - th) (R4 + ...)))). Built
 * only when somebody asks: first the cubic rows, then those that cost further stages, last those of the quadratures.
 * Source: the nested form of Hairer, Norsett and Wanner 1993, II.6; weights in the tables of the methods.
 * Assumed: the stages of the last step.
 * Knows nothing of events. */
#ifndef GB_DENSE_OUTPUT_H
#define GB_DENSE_OUTPUT_H

#include "gb_internal.h"

/* The cubic rows of the n states, at no cost; all rows of an implicit method. */
void gb_dense_hermite(gb_sim *sim);

/* Computes the stages that only dense output needs, and all rows of the n states. */
int gb_dense_complete(gb_sim *sim);

/* The rows of the quadratures as well: from here on the segment stands without the stages. */
int gb_dense_quadratures(gb_sim *sim);

/* The n states at theta in [0, 1]; the rows must be complete. */
void gb_dense_states(const gb_sim *sim, double theta, double *out);

/* The n states at theta, and their derivatives by theta: h times rates. */
void gb_dense_rates(const gb_sim *sim, double theta, double *states, double *rates);

/* The whole vector at t in [t0, t1]; the rows must be complete, those of the quadratures too, unless t is the front. */
void gb_dense_all(const gb_sim *sim, double t, double *out);

/* Moves the front back to theta: the states from their rows, the quadratures through the weights of its stages. */
void gb_dense_cut(gb_sim *sim, double theta);

#endif
