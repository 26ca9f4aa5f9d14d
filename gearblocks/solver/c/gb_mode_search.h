/* Modes of switches that read speeds of massless groups. Frozen modes give these speeds by a linear balance
 *     A(m) w = b(m),   m_i = mode_at(g_i(y, w)),
 * a piecewise linear equation: w, and with it all g_i, jump where a mode does, and where friction slides against a
 * contact whose damping is clipped A(m) is singular (g_i: no number), though other modes agree with each other. What
 * flips one after the other then goes in circles, or stops where A is singular. Method: the sets of modes by their
 * distance from the present ones, until all agree (Murty 1988, Linear Complementarity, ch. 1: one piece of finitely
 * many). Knows nothing of friction and contacts. */
#ifndef GB_MODE_SEARCH_H
#define GB_MODE_SEARCH_H

#include "gb_internal.h"

/* Event function i is clearly beyond a limit of its mode: by more than noise. */
int gb_is_beyond(gb_sim *sim, int i);

/* The event functions now have no number: the balance of massless groups is singular in these modes. */
int gb_balance_is_singular(const gb_sim *sim);

/* Takes the nearest modes that agree; 0: there are none, or the train has no massless groups (modes stay). */
int gb_search_modes(gb_sim *sim, int log);

#endif
