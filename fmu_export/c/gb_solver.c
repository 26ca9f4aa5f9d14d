/* Which of the solvers in this binary is taken. GB_SOLVER_VARIANTS: it holds those for x86-64-v3 and v4 besides. */
#include "gb_solver.h"

#include <stdlib.h>
#include <string.h>

#ifdef GB_SOLVER_VARIANTS
extern const gb_solver gb_solver_v3, gb_solver_v4;

/* What compilers use of these levels, and what tells their processors from those before; the system's part in it too.
 */
static int runs_v3(void) {
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
           __builtin_cpu_supports("bmi2");
}

static int runs_v4(void) {
    return runs_v3() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl");
}

#define THERE_ARE "x86-64-v4, x86-64-v3 and x86-64, as far as the processor has them"
#else
#define THERE_ARE "x86-64 alone"
#endif

const gb_solver *gb_solver_here(void) {
    const char *asked = getenv("GEARBLOCKS_VARIANT");
    if (asked && !*asked)
        asked = NULL;
#ifdef GB_SOLVER_VARIANTS
    if ((!asked || strcmp(asked, "x86-64-v4") == 0) && runs_v4())
        return &gb_solver_v4;
    if ((!asked || strcmp(asked, "x86-64-v3") == 0) && runs_v3())
        return &gb_solver_v3;
#endif
    const int plain = !asked || strcmp(asked, "x86-64") == 0 || strcmp(asked, "x86-64-v2") == 0; /* v2 gains nothing */
    return plain ? &gb_solver_plain : NULL;
}

const char *gb_solver_words(void) {
    return "the environment variable GEARBLOCKS_VARIANT names no code that is here and can be run; there "
           "are " THERE_ARE;
}
