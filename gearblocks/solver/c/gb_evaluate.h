/* The laws at one instant: time terms, the rates at the front, the event functions.
 * Knows nothing of steps and of what follows from the values. */
#ifndef GB_EVALUATE_H
#define GB_EVALUATE_H

#include "gb_internal.h"

/* Inputs and time columns at `lanes` instants; the last instant fills the lanes that are left. */
int gb_columns(gb_sim *sim, int lanes, gb_lanes *at);

/* The same at one instant, into tau_one. */
int gb_columns_at(gb_sim *sim, double t);

/* Inputs and time columns of a point, into tau_one. gb_input_broadcast puts the lanes of constant inputs right again.
 */
int gb_point_columns(gb_sim *sim, const gb_point *at);

/* The derivative at the front, into k1. */
int gb_first_derivative(gb_sim *sim, const double *tau);

/* The surfaces at the front, into s. */
int gb_surfaces_now(gb_sim *sim);

#endif
