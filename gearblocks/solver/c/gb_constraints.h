/* What is decided about a switched constraint at an event.
 * Knows nothing of how. */
#ifndef GB_CONSTRAINTS_H
#define GB_CONSTRAINTS_H

/* It transmits nothing (GB_FREE); a stop is open; it slides; or it stays active if its force keeps within its bounds.
 */
enum { GB_FREE, GB_IS_OPEN, GB_SLIDES, GB_CANDIDATE };

#endif
