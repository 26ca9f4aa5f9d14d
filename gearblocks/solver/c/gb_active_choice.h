/* Which of the active constraints are independent, once they change: rows reduced to echelon form, those that follow
 * from others marked (gb_active_set.h). And the active set as rigid ties where it is like them.
 *
 * Generated code calls it at events, so that it is compiled with the core and not into every model. Knows nothing of
 * how the active constraints were found. */
#ifndef GB_ACTIVE_CHOICE_H
#define GB_ACTIVE_CHOICE_H

#include "gb_active_set.h"

/* The active set: which of the constraints with is_active[i] are independent, with its factors; `redundant` marks those
 * whose force the motion does not tell. light: see gb_active_rows. */
void gb_active_choose(const gb_constraint_rows *rows, const double *value, const double *light, const int *is_active,
                      const double *matrix, gb_active_set *a);

/* What follows from an active set that is known, once a state was restored (gb_active_renew). */
void gb_active_restore(const gb_constraint_rows *rows, const double *value, const double *light, const double *matrix,
                       gb_active_set *a);

/* The active set as ties, where it is like them; with a diagonal mass matrix. */
void gb_active_tie(const gb_constraint_rows *rows, const double *mass, const double *inverse_mass, gb_active_set *a);

#endif
