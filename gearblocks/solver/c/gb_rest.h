/* A scale for a motion that has none yet: a train at rest whose sources rise softly (a torque 1 - cos wt, t^4). There,
 * errors are in a fixed ratio to what a step reaches, however short it is, and rounding is all that 1 - cos has. What
 * the sources drive within a window W from now: speeds v, with them the coordinates q and the energies that are
 * exchanged, v = W |f(t + W, y)|,   q, e = W |f(t + W, y + v)|. Assumed: no speed was ever other than 0. Knows nothing
 * of steps. */
#ifndef GB_REST_H
#define GB_REST_H

#include "gb_internal.h"

/* A speed has been other than 0, or has a natural scale. */
int gb_has_moved(const gb_sim *sim);

/* None has so far. */
static inline int gb_is_at_rest(gb_sim *sim) {
    if (!sim->head->control.moved) {
        sim->head->control.moved = gb_has_moved(sim);
    }
    return !sim->head->control.moved;
}

/* Gives states that rest a natural scale, where time alone drives them and their rates are 0 now. 1 where it did. */
int gb_scales_from_rest(gb_sim *sim);

#endif
