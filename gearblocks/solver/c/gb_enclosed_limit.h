/* An event function beside one of its limits, over a piece [a, b] of a step, from its enclosure there:
 *
 *     f(th) = side (limit - g(t, x(th))),   negative: its mode has been left.
 *
 * A corner is a start where f is 0 but for rounding, of whatever order: f = f' = 0 where cos(5 phi) - 1 begins at
 * phi = 0. Its side is decided by what lies just ahead, never by the sign of f there: enclosures over ever shorter
 * pieces from the start tell whether f falls or rises throughout, since rates keep their relative precision where the
 * values are rounding; where they tell neither, f that has not been clearly inside before it is clearly beyond was
 * never inside. Knows nothing of how crossings are located. */
#ifndef GB_ENCLOSED_LIMIT_H
#define GB_ENCLOSED_LIMIT_H

#include "gb_enclosure.h"
#include "gb_internal.h"

/* side 0: not to be watched. */
typedef struct gb_limit {
    int i;
    double side;
} gb_limit;

/* The limits of all event functions behind the affine ones, and the one of a number. */
int gb_limits(const gb_model *model);
gb_limit gb_limit_at(const gb_sim *sim, int number);

/* Encloses them over the piece; with_forces: constraint forces too. */
void gb_enclose(gb_sim *sim, int with_forces, double a, double b);

/* f and df/dth over the piece that was enclosed last. */
gb_interval gb_margin(const gb_sim *sim, gb_limit at);
gb_interval gb_margin_rate(const gb_sim *sim, gb_limit at);

/* How far below 0 f may lie by rounding. What begins many orders off its limit, as e^(40 - 100 t) does, rounds there no
 * more as at the start; of forces of constraints, and beside shafts without inertia, what is large may leave so much.
 */
double gb_margin_rounding(const gb_sim *sim, gb_limit at);

/* It starts on its limit. */
int gb_starts_on_limit(const gb_sim *sim, gb_limit at);

/* It starts on a corner and leaves its mode at once, within the piece [0, b] that was enclosed last; that is enclosed
 * anew. */
int gb_leaves_corner(gb_sim *sim, int with_forces, gb_limit at, double b, double tolerance);

/* *never: it starts on a corner, and was nowhere clearly inside its mode before the root. */
int gb_never_inside(gb_sim *sim, gb_limit at, double root, int *never);

#endif
