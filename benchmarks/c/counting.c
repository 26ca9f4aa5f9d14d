/* Marks for callgrind: where counting begins, and what has been counted since the last mark. Nothing outside of
 * valgrind. */
#include <valgrind/callgrind.h>

void begin_counting(void);
void counted(const char *name);

void begin_counting(void) {
    CALLGRIND_START_INSTRUMENTATION;
}

void counted(const char *name) {
    CALLGRIND_DUMP_STATS_AT(name);
}
