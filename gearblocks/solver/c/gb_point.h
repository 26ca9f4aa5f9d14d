/* The laws and the switched constraints at a point that the caller gives, for tools: nothing of a run changes. The
 * calls are those of gb_core.h: gb_probe, gb_constraints_of, gb_constraints_at.
 * Knows nothing of steps. */
#ifndef GB_POINT_H
#define GB_POINT_H

#include "gb_core.h"

#endif
