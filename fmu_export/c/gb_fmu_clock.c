/* The time that a step has taken: of the processor in this thread where the system tells, so that neither other threads
 * of the importer nor other programs count; on Windows that of the clock on the wall. No result of a run depends on it.
 */
#if !defined(_WIN32)
#define _POSIX_C_SOURCE 200112L
#endif

#include "gb_fmu_internal.h"

#include <time.h>

double gb_fmu_clock(void) {
#if defined(CLOCK_THREAD_CPUTIME_ID)
    struct timespec now;
    if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) == 0)
        return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
#endif
    return (double)clock() / (double)CLOCKS_PER_SEC;
}
