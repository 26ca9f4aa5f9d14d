/* Inputs: constants, tables and callbacks. Within a step a table keeps its segment, continued past its ends; an event
 * moves on to the next one, so that no breakpoint lies inside a step. Callbacks have pieces likewise, as their jumps
 * are found. Linear and cubic segments: textbook (cubic: second derivatives at the points). Knows nothing of laws and
 * methods. */
#ifndef GB_INPUTS_H
#define GB_INPUTS_H

#include "gb_internal.h"

/* Moves every table to the segment that begins at or holds t. With `log`, jumps of stepped tables become events. */
void gb_input_find(gb_sim *sim, double t, int log);

/* Whether a callback jumps within the step that has just been tried: 1, and that is where its piece ends. Told is a
 * jump by more than the tolerance of the values that makes most of their change there. Asked is up to `limit`. Fails
 * where the callback does. */
int gb_callback_jumps(gb_sim *sim, double limit);

/* Fills the lanes of all inputs that are no constants. */
int gb_input_lanes(gb_sim *sim, int lanes, const double *t, double *u);

/* Values of all inputs at one instant. */
int gb_input_values(gb_sim *sim, double t, double *value);

/* Writes the constants into all lanes, once. */
void gb_input_broadcast(gb_sim *sim);

#endif
