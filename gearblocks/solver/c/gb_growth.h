/* Motion that leaves every bound: steps outside the stability of their method, energy exchanged without end, values
 * that grow quicker than time can be told. fixed step:   |err_i| > size_i / 4 in most steps, err the embedded estimate,
 * size the largest value so far energy:       turnover 2^16 times what it was, again and again, in spans of time that
 * do not get longer finite time:  |y_i'| (t - t_start) > 1e10 |y_i|, |y_i| the largest so far, where a step falls below
 * rounding On the border of stability the estimates of the explicit methods are 0.4 to 2 times the size of the mode
 * that grows; a power of time of the turnover takes ever longer for the same factor. Knows nothing of what makes it
 * grow. */
#ifndef GB_GROWTH_H
#define GB_GROWTH_H

#include "gb_internal.h"

/* After a fixed step of an explicit method from y0 to z, its stages and the rates at its end in k. */
int gb_watch_fixed_step(gb_sim *sim, double h);

/* Where the turnover has passed head->growth.mark. */
int gb_watch_turnover(gb_sim *sim);

/* After GB_ERR_STEP and GB_ERR_NAN_RATE: the same code, or GB_ERR_ESCAPE by the state that grew until then. */
int gb_name_escape(gb_sim *sim, int code);

#endif
