/* Steps through narrow features: arguments x of functions that are flat for large |x|, in widths of the part that is
 * not. With  G(x) = 3 x / sqrt(x^2 + 4)  for bounded ones, in (-3, 3), and G(x) = x for periodic ones, a step may move
 * G by a twelfth of its range: from far outside it ends within three widths, where the function is seen, and what is
 * seen is the business of the error control. G is looked at in the middle of a step too, for motions that turn back.
 * Assumed: a step just computed, the rates at its end.
 * Knows nothing of errors. */
#ifndef GB_FEATURES_H
#define GB_FEATURES_H

#include "gb_internal.h"

/* The part of a step of size h that may be kept, in (0, 1]; proposes a limit of the step after it. */
double gb_features_part(gb_sim *sim, double h);

/* Whether a step of size h moves a feature: it is no small part of what the step before leaves it. */
static inline int gb_moves_feature(const gb_sim *sim, double h) {
    return sim->head->control.h_feature > 0.0 && h > 0.1 * sim->head->control.h_feature;
}

#endif
