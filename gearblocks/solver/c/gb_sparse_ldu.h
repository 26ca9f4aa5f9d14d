/* Sparse linear systems  scale^-1 A x = b  with A = L D U on a fixed symmetric pattern (gb_pattern in gb_model.h).
 * Assumed: the order of elimination is given and no pivoting is needed, as where A = E - g J with g small or J stable.
 * Method: right-looking elimination (George and Liu 1981); a forest (one entry per column) without pairs; its chains
 * two links at once.
 * Knows nothing of steps and models. */
#ifndef GB_SPARSE_LDU_H
#define GB_SPARSE_LDU_H

#include "gb_model.h"

/* Unknowns that follow others: that of step k is gain[k] times the one whose row stands in place[k] of its column (-1:
 * it follows none), and its equation counts as much for that one: N' A N x = N' b. */
typedef struct gb_ties {
    const int *place;
    const double *gain;
} gb_ties;

/* Factors L D U in place. diag: by unknown; inverse[k] = scale / pivot of step k; lower and upper become L and U. ties:
 * NULL, or those of the steps. Returns -1, or the unknown whose pivot is zero or not finite. */
int gb_factor(const gb_pattern *p, const gb_ties *ties, double scale, const double *diag, double *lower, double *upper,
              double *inverse);

/* x = scale (L D U)^-1 b, both by unknown (b may be x); work: pattern->n entries. */
void gb_solve(const gb_pattern *p, const double *inverse, const double *lower, const double *upper, const double *b,
              double *work, double *x);

/* Number of updates that columns with several entries make. */
long gb_pair_count(const gb_pattern *p);

/* How many colours gb_colours needs at most. */
int gb_colour_count(const gb_pattern *p);

/* Gives every unknown a colour, other than those of the unknowns that share an entry of S with it. */
void gb_colours(const gb_pattern *p, int *colour);

#endif
