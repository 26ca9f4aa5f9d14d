/* Error of the speeds of damped massless groups: w = f_q(y) is no state but the rate of a twist q, fast where the
 * damper is small against the spring (lambda = k/c). An error e of the states is J e of it, lambda e, however small e
 * is beside q: err = max_i |f_i(y1 + e) - f_i(y1)| / (rtol |f_i|max + noise)   over the twists with such a speed in
 * their rate. Assumed: the stages of an explicit step, the rates at its end. Knows nothing of dampers. */
#ifndef GB_MASSLESS_ERROR_H
#define GB_MASSLESS_ERROR_H

#include "gb_internal.h"

/* log2 of that error; log_error: that of the states, which the estimate is scaled to. */
double gb_log_massless_error(gb_sim *sim, double h, double log_error);

/* Inside an explicit step the defect d of the dense polynomial, h times as large, has the errors of these speeds
 * itself: the largest, in tolerances. */
double gb_largest_massless_defect(const gb_sim *sim, const double *d, double h);

#endif
