/* Rows of a record, [t | y (n_total) | modes (n_switches) | inputs (n_inputs)]: written within the segment that ends at
 * the front, and read: outputs and energies of rows (gb_evaluate of gb_core.h).
 * Knows nothing of who wants them. */
#ifndef GB_RECORD_H
#define GB_RECORD_H

#include "gb_internal.h"

/* Numbers in a row. */
size_t gb_row_length(const gb_model *m);

/* The modes at t, where the state is y: those of the front, or without location those that fit there. */
int gb_modes_between(gb_sim *sim, double t, const double *y, const double **mode);

/* The row at t within the segment that ends at the front. */
int gb_write_row(gb_sim *sim, double t, double *row);

/* Outputs at the front, of a run with located events of which none is pending there; dy: the rates there, or NULL. */
void gb_outputs_now(gb_sim *sim, const double *time_terms, const double *dy, const int *pick, int n_pick, double *out);

#endif
