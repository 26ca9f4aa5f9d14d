/* Outputs where switches slide: means of what they are on both sides. Knows nothing of runs. */
#ifndef GB_SLIDING_OUTPUTS_H
#define GB_SLIDING_OUTPUTS_H

#include "gb_internal.h"

/* Whether a recorded mode has shares in it. */
int gb_has_shares(const gb_model *model, const double *mode);

/* Outputs at a recorded row with shares, as the mean that they stand for; time and inputs are those of lane `lane` of
 * `at`. Fills z2 with the rates. */
void gb_outputs_with_shares(gb_sim *sim, const double *mode, const gb_lanes *at, int lane, const double *y,
                            double *out);

#endif
