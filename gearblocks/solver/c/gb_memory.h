/* Memory of a simulation: one block that changes during a run, and scratch that may be forgotten between calls;
 * opening and closing, parameters and inputs.
 * Knows nothing of what the numbers mean. */
#ifndef GB_MEMORY_H
#define GB_MEMORY_H

#include "gb_internal.h"

/* The method of the next step. */
void gb_set_method(gb_sim *sim, int method);

/* Numbers of a copy of the modes with the active set and what follows from it. */
size_t gb_modes_size(const gb_model *model);

#endif
