/* Arguments of event functions over a panel, a part [from, to] of a step: polynomials of degree 8 through 9 points,
 *
 *     x(th) = x(from) + sum b_i B_i,8(u),   u = (th - from)/(to - from),
 *
 * in Bernstein form: over a piece each lies between its least and largest coefficient there, its rate between those of
 * the differences (Lane and Riesenfeld 1981; pieces by de Casteljau's rule). The dense output is such a polynomial, and
 * so is what depends linearly on it. How far others are off is told at points between; where that is too far, the
 * panel is to be shorter.
 * Knows nothing of event functions. */
#ifndef GB_PANEL_H
#define GB_PANEL_H

#include "gb_internal.h"

/* The polynomials of the panel [from, to], half the last one where it is halved; *good: they hold. The dense rows must
 * be complete, and the rounding of the arguments is forgotten before each step. */
int gb_panel_fill(gb_sim *sim, double from, double to, int halved, int *good);

/* The arguments over [a, b] inside the panel; of a single point without their rates. */
void gb_panel_piece(gb_sim *sim, double a, double b);

#endif
