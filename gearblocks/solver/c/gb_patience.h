/* What is not looked at again for a while: twice as long after each look that found nothing, by modes. Knows nothing of
 * what is looked for. */
#ifndef GB_PATIENCE_H
#define GB_PATIENCE_H

#include <stddef.h>
#include <stdint.h>

enum { GB_MEMORY = 64 }; /* modes that are remembered */

typedef struct gb_patience {
    uint64_t modes[GB_MEMORY];
    long long at[GB_MEMORY], gap[GB_MEMORY]; /* the count at the next look; how many are left out before */
} gb_patience;

static inline int gb_was_looked_at(const gb_patience *patience, uint64_t modes) {
    return patience->modes[modes % GB_MEMORY] == modes;
}

/* Whether what comes as number `count` is left out. */
static inline int gb_is_patient(const gb_patience *patience, uint64_t modes, long long count) {
    return gb_was_looked_at(patience, modes) && count < patience->at[modes % GB_MEMORY];
}

/* A look as number `count`: at most so many are left out next, 0 where it found something. */
static inline void gb_looked(gb_patience *patience, uint64_t modes, long long count, int most) {
    const size_t slot = (size_t)(modes % GB_MEMORY);
    const long long longer = gb_was_looked_at(patience, modes) ? 2 * patience->gap[slot] + 1 : 1;
    patience->modes[slot] = modes;
    patience->gap[slot] = longer < most ? longer : most;
    patience->at[slot] = count + patience->gap[slot];
}

#endif
