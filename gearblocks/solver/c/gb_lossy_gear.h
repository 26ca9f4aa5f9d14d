/* Lossy gears: the friction that they lose grows with the force of their tie, lambda,
 *     lost = share (d lambda + rest) + rest,   d: direction of the slip,
 * on one of two sides (gb_constraint_rows.h): the gear drives, or is driven; what is lost is continuous in between, and
 * the motion with it. At rest the friction is bounded by what either direction would lose. For given sides that is a
 * linear complementarity problem whose bounds grow with other forces (gb_lcp.h), not symmetric any more; the sides are
 * those of its solution: a piecewise linear equation. Method: Newton steps over the pieces from the present sides (all
 * that disagree change at once, the first of them alone where that leads nowhere: Katzenelson 1965, Murty's least
 * index), then every combination. One solution wherever no efficiency is negative and gears stand in a row; none or two
 * where friction grows faster than what it slows down (jamming: Painleve 1895), where it is refused. Knows nothing of
 * events. */
#ifndef GB_LOSSY_GEAR_H
#define GB_LOSSY_GEAR_H

#include "gb_internal.h"

/* The train has any. */
int gb_has_lossy(const gb_sim *sim);

/* As gb_choose_active_set, with the sides of all lossy gears. Where the run starts no force before tells which of
 * several motions it is: it is refused then. */
int gb_choose_lossy(gb_sim *sim, int starting);

/* The constraint force of the loss of a lossy gear at rest, force, is nearer to its upper bound. */
int gb_loss_is_upper(const gb_sim *sim, int i, const double *force);

#endif
