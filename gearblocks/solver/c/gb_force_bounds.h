/* Bounds of the forces of constraints, those of the losses of lossy gears at rest among them (gb_loss.h). Knows nothing
 * of what is held. */
#ifndef GB_FORCE_BOUNDS_H
#define GB_FORCE_BOUNDS_H

#include "gb_loss.h"

/* tie_of: of the loss of a lossy gear its tie, -1 for all others (NULL: there is none); its losses are five numbers
 * further each, of which the part `shrink` is taken off (NULL: nothing). */
typedef struct gb_force_bounds {
    const double *lower, *upper, *losses;
    const int *tie_of;
    const double *shrink;
} gb_force_bounds;

static inline int gb_split_is_loss(const gb_force_bounds *bounds, int i) {
    return bounds->tie_of && bounds->tie_of[i] >= 0;
}

/* States of trains with constraints, and loads of these, have no digits left below it that a load and what holds it
 * could be compared by: they come out of underflow, and count as none. */
#define GB_UNDERFLOW 1e-200

static inline void gb_forget_underflow(double *of, int n) {
    for (int i = 0; i < n; i++) {
        of[i] = of[i] < GB_UNDERFLOW && of[i] > -GB_UNDERFLOW ? 0.0 : of[i];
    }
}

#endif
