/* Motion that leaves every bound: steps outside the stability of their method, energy beyond the squares of numbers,
 * values that grow quicker than time can be told. fixed step:   |err_i| > size_i / 4 in most steps, err the embedded
 * estimate, size the largest value so far energy:       turnover > GB_BEYOND finite time:  |y_i'| (t - t_start) > 1e10
 * |y_i|, |y_i| the largest so far, where a step falls below rounding On the border of stability the estimates of the
 * explicit methods are 0.4 to 6 times the mode that grows. Knows nothing of what makes it grow. */
#ifndef GB_GROWTH_H
#define GB_GROWTH_H

#include "gb_internal.h"

/* J. A linear law may grow far and its run be right; the squares of values beyond 1e100 soon leave the range of
 * numbers. */
#define GB_BEYOND 1e200

/* After a fixed step of an explicit method from y0 to z, its stages and the rates at its end in k. */
int gb_watch_fixed_step(gb_sim *sim, double h);

/* The turnover has passed GB_BEYOND: GB_ERR_ESCAPE, or GB_ERR_UNSTABLE, by the state that grows quickest. */
int gb_name_growth(gb_sim *sim);

/* Speeds beyond those of all machinery that go on growing, and steps that become as much shorter (what is stiffer the
 * further it goes): GB_ERR_ESCAPE, where the run to `target` would take many times as many steps as all so far.
 * Steps that hardly bring it on: GB_ERR_STALL by the state with the largest error. */
int gb_watch_pace(gb_sim *sim, double target);

/* After GB_ERR_STEP and GB_ERR_NAN_RATE: the same code, or GB_ERR_ESCAPE by the state that grew until then. */
int gb_name_escape(gb_sim *sim, int code);

#endif
