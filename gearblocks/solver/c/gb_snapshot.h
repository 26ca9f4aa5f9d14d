/* The changing state of a simulation as one block of memory without pointers: size, copy out, copy in. The calls are
 * those of gb_core.h: gb_snapshot_size, gb_save, gb_fits, gb_restore.
 *
 * A block carries a checksum over all its bytes, so that one of other bits is known for damaged: each word is mixed in
 * by a map that is one to one in the word and in the sum, and a change of a single word never goes unnoticed.
 * Knows of what lies in the block only what must hold for the solver to go on. */
#ifndef GB_SNAPSHOT_H
#define GB_SNAPSHOT_H

#include "gb_core.h"

#endif
