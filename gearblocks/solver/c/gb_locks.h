/* What gb_lock.c, gb_impact.c and gb_lossy.c share. */
#ifndef GB_LOCKS_H
#define GB_LOCKS_H

#include "gb_internal.h"

/* Decided about a lock at an event. */
enum { GB_FREE, GB_IS_OPEN, GB_SLIDES, GB_CANDIDATE };

/* gb_lock.c */
int gb_is_stuck(const gb_sim *sim, int i);
int gb_is_stop(const gb_sim *sim, int i);
int gb_is_unlimited(const gb_sim *sim, int i);
int gb_touches(const gb_sim *sim, int i);
int gb_does_rub(const gb_sim *sim, int i);
void gb_slips_now(gb_sim *sim);
int gb_weigh(gb_sim *sim);
int gb_refuse_tie_up(gb_sim *sim, int count);
double gb_weighed_force(const gb_sim *sim, int i);
double gb_weighed_rate(const gb_sim *sim, int i, double *size);
double gb_rate_rounding(const gb_sim *sim, int i, double size);

/* gb_impact.c: impulses where a stop is hit or an unlimited lock slips, and the slips after it. */
int gb_impact(gb_sim *sim);

/* gb_lossy.c: as gb_weigh, for every combination of options of the lossy ties; the one that holds true is taken. */
int gb_has_lossy(const gb_sim *sim);
int gb_weigh_lossy(gb_sim *sim);

#endif
