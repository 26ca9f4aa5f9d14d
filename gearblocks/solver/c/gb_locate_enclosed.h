/* Where event functions of any form leave their mode: the first th in [0, 1] with
 *
 *     f(th) = side (limit - g(t, x(th))) < 0.
 *
 * Pieces of the step are taken from the left. Enclosures (gb_enclosure.h) of g and dg/dth over a piece [a, b] tell
 *     free      f >= 0 by its values, or by the tangents from both ends that its rates allow,
 *     one root  f falls throughout and is negative at b: found by secants,
 *     open      neither: the piece is halved,
 * so that no crossing between two looks is missed (branch and bound; Hansen and Walster 2004, ch. 9). At the width to
 * which an instant can be told, or a value to rounding, its ends decide: a touch is no crossing.
 * Assumed: the arguments are what gb_panel.h says they are.
 * Knows nothing of what an event does. */
#ifndef GB_LOCATE_ENCLOSED_H
#define GB_LOCATE_ENCLOSED_H

#include "gb_internal.h"

/* The event functions with enclosures; fills located and side, up to the first event that is known already. */
int gb_locate_enclosed(gb_sim *sim);

#endif
