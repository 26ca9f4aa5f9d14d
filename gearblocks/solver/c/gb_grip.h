/* Friction that has let go in one mode of a switch that slides, and would hold the mean of both: the slip has not
 * begun. Knows nothing of shares. */
#ifndef GB_GRIP_H
#define GB_GRIP_H

#include "gb_internal.h"

/* What does not slip, though it may, holds; how many. */
int gb_grip_again(gb_sim *sim);

/* It does not: as before the last gb_grip_again. */
void gb_let_go_again(gb_sim *sim);

#endif
