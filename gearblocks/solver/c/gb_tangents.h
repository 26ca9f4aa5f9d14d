/* Tangents beside a run (gb_tangents of gb_core.h): columns D of dy/dy0 over the n states, through steps and events.
 *
 * Along a step they are the derivative of the step itself (internal differentiation: Bock 1983); with its stages x_j
 *     K_j = J(x_j) (D + h sum a_jl K_l),   D <- D + h sum b_l K_l
 * At an event with the surface g = 0, rates f- and f+, and the map y+ = R(y-) (saltation: Aizerman and Gantmakher 1958)
 *     dt = -(g_x D) / (g_x f- + g_t),   w = D + f- dt,   D <- R_x w - f+ dt
 * dt = 0 at an event of time. Derivatives along a direction are differences of fourth order in the modes of the step,
 * where all laws are smooth; R_x w is one of whole events. No derivative exists where a surface is only grazed, where
 * motions beside reach two surfaces one after the other, and where an event beside decides otherwise.
 *
 * Knows nothing of what is done with the columns. */
#ifndef GB_TANGENTS_H
#define GB_TANGENTS_H

#include "gb_internal.h"

enum { GB_BESIDE = 4 }; /* points of a difference */

extern const double gb_beside[GB_BESIDE];
extern const double gb_beside_weight[GB_BESIDE];

/* Places in the room of the caller: vectors n_total long, of stages as many as there are. */
typedef struct gb_tangent_room {
    gb_lanes lanes;
    double *state, *combined, *moved, *rates; /* scratch */
    double *slopes, *columns;                 /* rates of the stages: of the state, of each column */
    double *before, *rates_before, *rates_after, *beyond;
    double *functions, *speeds, *surfaces; /* event functions; how fast they change along the motion, along a column */
    double *delay;                         /* dt by column */
    double *block_before, *block_after;    /* saved states */
} gb_tangent_room;

/* Laid out from `base` on; answers how many numbers there are. */
size_t gb_tangent_lay(const gb_sim *sim, int count, double *base, gb_tangent_room *room);

/* How far along v a difference goes: a small part of the size of each state. 0: v is zero. */
double gb_tangent_reach(const gb_sim *sim, const double *y, const double *v);

/* The columns along the step that ended at the front. */
int gb_tangents_step(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room);

/* Whether the step that ended at the front has an event function turn at its limit: motions beside reach it, or do not.
 */
int gb_tangents_graze(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room);

/* An instant at which no derivative exists. */
void gb_tangents_note(gb_tangents *tangents, double t);

/* What is pending at the front, before it is applied and after. */
int gb_tangents_before(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room);
int gb_tangents_after(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room);

#endif
