/* Minimum-norm split: forces of redundant active constraints, which the motion does not tell, are the smallest that
 * give the same slip accelerations, each within its bounds; they exceed them together once there is no such split. min
 * |x|,   W (x - lambda) = 0,   lower <= x <= upper Bounds of the loss of a lossy gear grow with the force of its tie
 * (gb_loss.h). Knows nothing of how the active set came about. */
#ifndef GB_FORCE_SPLIT_H
#define GB_FORCE_SPLIT_H

#include "gb_active_set.h"
#include "gb_force_bounds.h"

/* The split of the active constraints, into `force`; `violation`: of each of them by how much no split is within its
 * bounds, < 0: by how much the load may grow, both as slip acceleration. */
void gb_split(const gb_delassus *W, gb_active_set *a, const int *is_active, const gb_force_bounds *bounds,
              double *force, double *violation);

/* Forces within the bounds with which all that take part rest, b: their slip accelerations without forces. With lossy
 * gears; what the complementarity problem finds may slip although there are such forces. Where there are none: those
 * that leave least. */
void gb_split_at_rest(const gb_lcp *problem, const double *b, const gb_force_bounds *bounds, double *force);

/* By how much the force of each active constraint exceeds its bounds, < 0 inside; -1 for all others. */
static inline void gb_split_forces(const gb_delassus *W, gb_active_set *a, const int *is_active,
                                   const gb_force_bounds *bounds, double *force, double *violation) {
    int redundant = 0;
    for (int i = 0; i < W->n; i++) {
        redundant = redundant || (is_active[i] && a->redundant[i] != 0.0);
    }
    if (redundant) {
        gb_split(W, a, is_active, bounds, force, violation);
    }
    for (int i = 0; i < W->n; i++) {
        if (!is_active[i]) {
            violation[i] = -1.0;
        } else if (a->redundant[i] == 0.0) {
            const double over = gb_split_is_loss(bounds, i)
                                    ? gb_loss_excess(bounds->losses + 5 * i, force[bounds->tie_of[i]], force[i])
                                    : fmax(force[i] - bounds->upper[i], bounds->lower[i] - force[i]);
            violation[i] = over > -HUGE_VAL ? over : -1.0;
        }
    }
}

#endif
