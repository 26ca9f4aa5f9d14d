/* What limited the steps of a run, counted where somebody asks (gb_account of gb_core.h): which state had the largest
 * error, or what else chose the size. Without an account a test of a pointer is all that it costs. Knows nothing of
 * components. */
#ifndef GB_ACCOUNT_H
#define GB_ACCOUNT_H

#include "gb_internal.h"
#include "gb_vector.h"

/* The step begins with a size h that the step control wants; one that ends at `limit` is limited by that. */
void gb_account_size(gb_sim *sim, double h);

/* The step to `end` was accepted, as far as the front; or the trial was refused for this cause (GB_BY_DOUBT: it was too
 * long to tell its events). Counts refused trials for gb_stats too. */
void gb_account_accepted(gb_sim *sim, double end, double limit);
void gb_account_refused(gb_sim *sim, int cause);

/* Keeps in mind what makes the error of the trial just computed. */
static inline void gb_account_error(gb_sim *sim, int cause) {
    if (sim->account) {
        sim->account->cause = cause;
    }
}

/* The larger of two errors, the second one of this cause. */
static inline double gb_account_worse(gb_sim *sim, double error, double other, int cause) {
    if (other > error) {
        gb_account_error(sim, cause);
    }
    return gb_max(error, other);
}

#endif
