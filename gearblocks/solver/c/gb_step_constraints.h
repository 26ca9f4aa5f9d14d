/* The active rows G of switched constraints in an implicit step: the answer of its matrix S to any right side has the
 * slips that are asked for. Method: where they are like ties between neighbours in the elimination each speed follows
 * the next (gb_sparse_ldu.h), in a time that does not grow with their number. Else speeds that single rows hold have an
 * inertia without bound; for the others S^-1 G' and (G S^-1 G')^-1. Knows nothing of stages. */
#ifndef GB_STEP_CONSTRAINTS_H
#define GB_STEP_CONSTRAINTS_H

#include "gb_internal.h"

/* How many independent rows are active. */
int gb_n_active_rows(const gb_sim *sim);

/* Whether the active rows are ties that the elimination takes: then these, into implicit.tie_place. */
int gb_tie_unknowns(gb_sim *sim);

/* The slip of the j-th active row at such speeds. */
double gb_along_row(const gb_sim *sim, int j, const double *speeds);

/* Evaluates the rows, and puts the speeds that they hold into the diagonal of the matrix that is about to be factored.
 */
void gb_hold_speeds(gb_sim *sim);

/* Behind the factors of the matrix. */
void gb_factor_constraints(gb_sim *sim);

/* The slips that the answer to k has, gamma times its own since the constrained motion has none: into
 * constraints.right. Where rows change with the position, so does what keeps them at zero. */
void gb_wanted_slips(gb_sim *sim, const double *k);

/* Adds the constraint forces to an answer x, so that its speeds slip as constraints.right says. */
void gb_constrain_answer(gb_sim *sim, double *x);

#endif
