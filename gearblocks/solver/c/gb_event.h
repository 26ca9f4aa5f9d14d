/* Events at the front: pending switches flip, modes and switched constraints are settled until nothing changes.
 * Knows nothing of where events lie in a step. */
#ifndef GB_EVENT_H
#define GB_EVENT_H

#include "gb_internal.h"

/* Makes the limits follow the modes and flips what is inconsistent, until nothing is. */
int gb_settle_modes(gb_sim *sim, int log);

/* Switches the constraints, and what else flips because of it. */
int gb_settle_all(gb_sim *sim, int log);

/* What slides or rests on a limit and may no longer leaves it. A friction that rested was held whatever was asked of
 * it: what it does from here is decided with all others. */
int gb_settle_on_limits(gb_sim *sim);

/* What comes before: an event; nothing, so that angles that are not given are those at rest; a motion whose states are
 * given, so that angles that dampers and friction hold are what they were. */
enum { GB_AT_EVENT, GB_FROM_REST, GB_GOING_ON };

/* Puts massless groups into balance, and takes the modes that belong to it. */
int gb_balance_massless(gb_sim *sim, int before);

/* States that take a value as the modes change, from those in events.mode_before. */
int gb_update_states(gb_sim *sim);

/* What stays exactly on a limit has the mode that its condition says; and what follows from that. */
int gb_settle_exact_limits(gb_sim *sim, int log);

/* Carries out what is pending at the front. */
int gb_apply_event(gb_sim *sim);

#endif
