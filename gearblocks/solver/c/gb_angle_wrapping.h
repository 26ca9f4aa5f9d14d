/* Angle wrapping: states that no law can tell from themselves less whole turns are kept near zero,
 *     angle = y + carry + 2 pi count,
 * count and carry among the quadratures (gb_wrapped in gb_model.h). Inside a step the angle follows h w plus what the
 * rates depart from w, so that at constant speed not a bit is lost. Sums in two doubles: gb_double_double.h.
 * Knows nothing of what the angles are for. */
#ifndef GB_ANGLE_WRAPPING_H
#define GB_ANGLE_WRAPPING_H

#include "gb_internal.h"

/* The largest step not above h in which no wrapped angle moves too far. */
double gb_wrapping_step(const gb_sim *sim, double h);

/* The front after a whole step: y0 + (h k1 + departure) in two doubles, the lower one carried on. */
void gb_wrapping_advance(gb_sim *sim);

/* The dense rows [from, to) of the wrapped angles, from departures: at constant speed all but the first are zero. */
void gb_wrapping_rows(gb_sim *sim, int from, int to);

/* Takes whole turns off the wrapped angles at the front; the modes of tables over them are numbered anew. */
int gb_wrap_angles(gb_sim *sim, int with_modes);

#endif
