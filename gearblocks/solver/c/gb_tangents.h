/* Tangents beside a run (gb_tangents of gb_core.h): columns D of dy/dy0 over the n states, through steps and events.
 *
 * Along a step they are the derivative of the step itself (internal differentiation: Bock 1983); with its stages x_j
 *     K_j = J(x_j) (D + h sum a_jl K_l),   D <- D + h sum b_l K_l
 * At an event with the surface g = 0, rates f- and f+, and the map y+ = R(y-, t) (saltation: Aizerman and Gantmakher
 * 1958)
 *     dt = -(g_x D) / (g_x f- + g_t),   w = D + f- dt,   D <- R_x w + R_t dt - f+ dt
 * dt = 0 at an event of time. The column of a parameter p has + f_p in K_j, + g_p in dt, + R_p, and dt = dt_e/dp at an
 * event of time. Derivatives along a direction are differences of fourth order in the modes of the step,
 * where all laws are smooth; that of R is one of whole events. No derivative exists where a surface is only grazed,
 * where motions beside reach two surfaces one after the other, and where an event beside decides otherwise.
 *
 * The calls are those of gb_core.h: gb_tangent_size, gb_tangents_run. Knows nothing of what is done with the columns.
 */
#ifndef GB_TANGENTS_H
#define GB_TANGENTS_H

#include "gb_core.h"

#endif
