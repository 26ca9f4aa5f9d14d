/* The step matrix S = E - g dG/dx - g^2 dG/ds B (see gb_model.h) at a point that the caller gives, for tools. The
 * calls are those of gb_core.h: gb_pattern_of, gb_step_matrix_..., gb_kinematic_rates.
 * Knows nothing of steps. */
#ifndef GB_STEP_MATRIX_H
#define GB_STEP_MATRIX_H

#include "gb_core.h"

#endif
