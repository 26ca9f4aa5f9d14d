/* The changing state of a simulation as one block of memory without pointers: size, copy out, copy in. The calls are
 * those of gb_core.h: gb_snapshot_size, gb_save, gb_restore.
 * Knows nothing of what lies in the block. */
#ifndef GB_SNAPSHOT_H
#define GB_SNAPSHOT_H

#include "gb_core.h"

#endif
