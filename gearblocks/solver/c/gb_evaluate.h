/* The laws at one instant: time terms of points, the rates at the front, the event functions.
 * Knows nothing of steps and of what follows from the values. */
#ifndef GB_EVALUATE_H
#define GB_EVALUATE_H

#include "gb_time_terms.h"

/* Inputs and time terms of a point, into `instant`. gb_input_broadcast puts the lanes of constant inputs right again.
 */
int gb_point_time_terms(gb_sim *sim, const gb_point *at);

/* The derivative at the front, into k1. */
int gb_first_derivative(gb_sim *sim, const gb_lanes *at);

/* The event functions at the front, into events.s. */
int gb_event_functions_now(gb_sim *sim);

#endif
