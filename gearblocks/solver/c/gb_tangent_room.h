/* What tangents need besides the run (see gb_tangents.h): places in the room of the caller, and the points of a
 * difference of fourth order. Knows nothing of steps and events. */
#ifndef GB_TANGENT_ROOM_H
#define GB_TANGENT_ROOM_H

#include "gb_vector.h"

enum { GB_BESIDE = 4 }; /* points of a difference */

static inline double gb_beside(int point) {
    return point < 2 ? point - 2.0 : point - 1.0;
}

static inline double gb_beside_weight(int point) {
    const double size = point == 0 || point == GB_BESIDE - 1 ? 1.0 / 12.0 : 8.0 / 12.0;
    return point % 2 == 0 ? size : -size;
}

/* Places in the room of the caller: vectors n_total long, of stages as many as there are. */
typedef struct gb_tangent_room {
    gb_lanes lanes;
    const double *scale;                      /* sizes of the states, from the caller */
    double *state, *combined, *moved, *rates; /* scratch */
    double *slopes, *columns;                 /* rates of the stages: of the state, of each column */
    double *before, *rates_before, *rates_after, *beyond;
    double *functions, *speeds, *surfaces; /* event functions; how fast they change along the motion, along a column */
    double *delay;                         /* dt by column */
    double *block_before, *block_after;    /* saved states */
    gb_lanes beside[GB_BESIDE];            /* of trains with other parameters (gb_tangent_parameter.h): time terms, */
    double *par[GB_BESIDE], *mode[GB_BESIDE], *lo, *hi; /* values, modes; limits of one of them */
} gb_tangent_room;

#endif
