/* Random calls of an FMU, compiled together with its sources: as an importer makes them, and as none should.
 *
 *     fuzz CALLS SEED LIMIT [LONG]
 *
 * Steps from 1e-300 to 1e300 s (one of LONG steps is longer than 1 s; 0: none), values on, near and beyond their
 * bounds, references that do not exist, calls out of turn, saved states with flipped bits. Ends with 1 where a call
 * takes more than LIMIT seconds of processor time, a status is none of FMI's, or an error comes without a message in
 * the log, a value that is given with fmi2OK is not finite, a saved state that was changed is accepted, or one that was
 * not is refused. Sanitizers say the rest. Prints the number of calls and the longest one of each kind. */
#define _POSIX_C_SOURCE 200809L
#include "fmi2.h"

#include "gb_fmu.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { INSTANCES = 2, STATES = 4, REFS = 8 };

typedef struct instance {
    fmi2Component c;
    int running;
    double t;
    fmi2FMUstate saved[STATES];
    double saved_t[STATES];
    int saved_running[STATES];
} instance;

/* Kinds of calls that are told apart in the report. */
enum { LIFE, SETUP, BEGIN, STEP, GET, SET, STATE, BYTES, OTHER, KINDS };
static const char *const kind_names[KINDS] = {"life", "setup", "begin", "step", "get",
                                              "set",  "state", "bytes", "other"};

static struct {
    unsigned long long random;
    long long calls, failures, count[KINDS], good[KINDS], statuses[6];
    double limit, longest[KINDS], sum[KINDS];
    double longest_h;
    long share_of_long; /* one of so many steps is long; 0: none */
    int logged;
    char line[1024];
} all;

/* ---- random numbers (splitmix64) ------------------------------------------------------------------------------- */

static unsigned long long bits(void) {
    unsigned long long z = all.random += 0x9e3779b97f4a7c15ull;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
}
static double uniform(void) {
    return (double)(bits() >> 11) * 0x1p-53;
}
static int below(int n) {
    return (int)(bits() % (unsigned long long)n);
}
static double power(double low, double high) {
    return pow(10.0, low + (high - low) * uniform());
}

/* ---- calls ----------------------------------------------------------------------------------------------------- */

static void log_line(fmi2ComponentEnvironment env, fmi2String name, fmi2Status status, fmi2String category,
                     fmi2String message, ...) {
    va_list args;
    (void)env;
    (void)name;
    (void)status;
    (void)category;
    va_start(args, message);
    vsnprintf(all.line, sizeof all.line, message, args);
    va_end(args);
    all.logged++;
}
static const fmi2CallbackFunctions callbacks = {log_line, calloc, free, NULL, NULL};

static void fail(const char *what, double value) {
    all.failures++;
    fprintf(stderr, "call %lld: %s (%g); last message: %s\n", all.calls, what, value, all.line);
}

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double began;
static void before(void) {
    all.logged = 0;
    began = seconds();
}

/* Takes down a call that has just ended; `value`: what to say of it where it failed. */
static fmi2Status after(int kind, fmi2Status status, double value) {
    const double took = seconds() - began;
    all.calls++;
    all.count[kind]++;
    all.good[kind] += status == fmi2OK;
    all.sum[kind] += took;
    if (took > all.longest[kind]) {
        all.longest[kind] = took;
        if (kind == STEP)
            all.longest_h = value;
    }
    if (took > all.limit)
        fail(kind_names[kind], took);
    if (status < fmi2OK || status > fmi2Pending)
        fail("no status of FMI", status);
    else
        all.statuses[status]++;
    if (status != fmi2OK && kind != OTHER && !all.logged)
        fail("an error without a message", value);
    return status;
}

#define CALL(kind, value, call) (before(), after(kind, (call), value))

/* ---- references and values --------------------------------------------------------------------------------------- */

static const gb_fmu_entry *entry_of(fmi2ValueReference ref) {
    const unsigned kind = ref >> 24, position = ref & 0xffffffu;
    const gb_fmu_table *table = &gb_fmu_the_table;
    return kind < GB_FMU_KINDS && position < (unsigned)table->count[kind] ? &table->entries[kind][position] : NULL;
}

/* One that there is, of that kind or of parameters; mostly one that may be set while the model runs. */
static fmi2ValueReference any_of(int wanted) {
    const gb_fmu_table *table = &gb_fmu_the_table;
    const int kind = table->count[wanted] > 0 ? wanted : GB_FMU_PARAMETER, count = table->count[kind];
    int position = count > 0 ? below(count) : 0;
    for (int i = 0; i < 8 && count > 0 && kind == GB_FMU_PARAMETER && !table->entries[kind][position].tunable; i++)
        position = below(count);
    return ((fmi2ValueReference)kind << 24) + (fmi2ValueReference)position;
}

static fmi2ValueReference any_reference(void) {
    return below(200) == 0 ? (fmi2ValueReference)bits() : any_of(below(GB_FMU_KINDS));
}

/* Mostly near the start value, sometimes a bound or beyond, seldom no number at all. */
static double any_value(fmi2ValueReference ref) {
    static const double odd[] = {0.0,    -0.0,   1e300,   -1e300,   5e-324,   -5e-324,
                                 1e-320, 1e-160, DBL_MAX, -DBL_MAX, HUGE_VAL, -HUGE_VAL};
    const gb_fmu_entry *entry = entry_of(ref);
    const double start = entry ? entry->start : 1.0;
    switch (below(40)) {
    case 0:
        return odd[below((int)(sizeof odd / sizeof odd[0]))];
    case 1:
        return NAN;
    case 2:
        return entry ? entry->lower : 0.0;
    case 3:
        return entry ? entry->upper : 0.0;
    case 4:
        return start * power(-3.0, 3.0);
    case 5:
        return (uniform() - 0.5) * power(-3.0, 6.0);
    default:
        return start * (0.8 + 0.4 * uniform());
    }
}

/* ---- what is called ------------------------------------------------------------------------------------------- */

static void drop_states(instance *x) {
    for (int i = 0; i < STATES; i++)
        CALL(OTHER, i, fmi2FreeFMUstate(x->c, &x->saved[i]));
}

static void open_instance(instance *x) {
    before();
    x->c = fmi2Instantiate("fuzz", fmi2CoSimulation, gb_fmu_the_table.token, "", &callbacks, fmi2False, below(2));
    after(LIFE, fmi2OK, 0.0);
    x->running = 0;
    x->t = 0.0;
    if (!x->c) {
        fprintf(stderr, "no instance: %s\n", all.line);
        exit(2);
    }
}

static void close_instance(instance *x) {
    drop_states(x);
    before();
    fmi2FreeInstance(x->c);
    after(LIFE, fmi2OK, 0.0);
}

static void set_some(instance *x, int kind_mostly) {
    fmi2ValueReference refs[REFS];
    double values[REFS];
    const int n = below(3) + 1;
    for (int i = 0; i < n; i++) {
        refs[i] = below(10) ? any_of(kind_mostly) : any_reference();
        values[i] = any_value(refs[i]);
    }
    if (n > 1 && below(500) == 0)
        CALL(SET, 0.0, fmi2SetReal(x->c, refs, (size_t)n, NULL));
    CALL(SET, values[0], fmi2SetReal(x->c, refs, (size_t)n, values));
}

static void start_instance(instance *x) {
    static const double tolerances[] = {0.0, 1.0, 1e-3, 1e-5, 1e-7, 1e-9, 1e-300, 1e300, -1.0, NAN, HUGE_VAL};
    const double start = below(10) ? 0.0 : (uniform() - 0.5) * power(-3.0, 9.0);
    const double stop = start + (below(5) ? power(-2.0, 3.0) : power(-300.0, 300.0));
    const double tolerance = tolerances[below((int)(sizeof tolerances / sizeof tolerances[0]))];
    for (int i = below(3); i > 0; i--)
        set_some(x, GB_FMU_PARAMETER);
    const fmi2Status set =
        CALL(SETUP, tolerance, fmi2SetupExperiment(x->c, below(4) == 0, tolerance, start, below(2), stop));
    CALL(BEGIN, 0.0, fmi2EnterInitializationMode(x->c));
    for (int i = below(3); i > 0; i--)
        set_some(x, below(2) ? GB_FMU_INPUT : GB_FMU_START);
    x->running = CALL(BEGIN, 0.0, fmi2ExitInitializationMode(x->c)) == fmi2OK;
    if (set < fmi2Discard)
        x->t = start;
}

static void get_some(instance *x) {
    fmi2ValueReference refs[REFS];
    double values[REFS];
    const int n = below(REFS) + 1;
    for (int i = 0; i < n; i++)
        refs[i] = below(10) ? any_of(GB_FMU_OUTPUT) : any_reference();
    if (CALL(GET, refs[0], fmi2GetReal(x->c, refs, (size_t)n, values)) == fmi2OK)
        for (int i = 0; i < n; i++)
            if (!isfinite(values[i]))
                fail("a value that is not finite", values[i]);
}

static double step_size(void) {
    static const double odd[] = {0.0, -1e-3, NAN, HUGE_VAL, -HUGE_VAL, 5e-324};
    if (all.share_of_long > 0 && below((int)all.share_of_long) == 0)
        return below(3) ? power(0.0, 9.0) : power(9.0, 308.0);
    switch (below(50)) {
    case 0:
        return odd[below((int)(sizeof odd / sizeof odd[0]))];
    case 1:
        return power(-300.0, -6.0);
    default:
        return power(-6.0, -2.0);
    }
}

static void step(instance *x) {
    const double h = step_size(), t = below(100) ? x->t : x->t + (uniform() - 0.5) * power(-9.0, 300.0);
    const fmi2Status status = CALL(STEP, h, fmi2DoStep(x->c, t, h, below(2)));
    if (status == fmi2Discard) {
        double reached = NAN;
        CALL(OTHER, 0.0, fmi2GetRealStatus(x->c, fmi2LastSuccessfulTime, &reached));
        if (!(reached > x->t && reached < t + h))
            fail("a step that ends on its way does not say where", reached);
        if (below(2)) /* asked for again, or gone on from there */
            CALL(STEP, h, fmi2DoStep(x->c, t, h, fmi2True));
    } else if (status != fmi2OK && h > 0.0 && t == x->t) {
        x->running = below(4) == 0;
    }
    CALL(OTHER, 0.0, fmi2GetRealStatus(x->c, fmi2LastSuccessfulTime, &x->t));
}

static void state(instance *x) {
    const int i = below(STATES);
    switch (below(4)) {
    case 0:
    case 1:
        x->saved_t[i] = x->t;
        x->saved_running[i] = x->running;
        if (CALL(STATE, 0.0, fmi2GetFMUstate(x->c, &x->saved[i])) != fmi2OK)
            fail("no state is given", i);
        break;
    case 2:
        if (CALL(STATE, 1.0, fmi2SetFMUstate(x->c, x->saved[i])) == fmi2OK) {
            x->t = x->saved_t[i];
            x->running = x->saved_running[i];
        } else if (x->saved[i])
            fail("a state is not taken back", i);
        break;
    default:
        CALL(OTHER, 0.0, fmi2FreeFMUstate(x->c, &x->saved[i]));
    }
}

/* Changes some bytes; 0: they are as before. */
static int damage(fmi2Byte *bytes, size_t size) {
    const fmi2Byte flip = (fmi2Byte)(1 << below(8));
    const size_t at = (size_t)(bits() % size);
    switch (below(6)) {
    case 0:
        return 0;
    case 1:
        for (size_t i = at; i < size && i < at + 8; i++)
            bytes[i] = (fmi2Byte)~bytes[i];
        return 1;
    case 2:
        for (size_t i = at; i < size; i++)
            bytes[i] = (fmi2Byte)(bytes[i] ^ (1 + below(255)));
        return 1;
    default: /* the front, with what chooses among tables, more often than its share */
        bytes[below(2) ? at : at % (size < 2048 ? size : 2048)] ^= (char)flip;
        return 1;
    }
}

static void through_bytes(instance *x, instance *other) {
    fmi2FMUstate now = NULL, copy = NULL;
    size_t size = 0;
    CALL(STATE, 0.0, fmi2GetFMUstate(x->c, &now));
    CALL(BYTES, 0.0, fmi2SerializedFMUstateSize(x->c, now, &size));
    fmi2Byte *bytes = malloc(size + 1);
    CALL(BYTES, 0.0, fmi2SerializeFMUstate(x->c, now, bytes + 1, size)); /* anywhere in memory */
    const int damaged = damage(bytes + 1, size), cut = below(10) == 0;
    const fmi2Status status =
        CALL(BYTES, 1.0, fmi2DeSerializeFMUstate(other->c, bytes + 1, cut ? (size_t)(bits() % size) : size, &copy));
    if ((status == fmi2OK) != (!damaged && !cut))
        fail(damaged || cut ? "a damaged state is accepted" : "a sound state is refused", damaged);
    if (status == fmi2OK && CALL(STATE, 1.0, fmi2SetFMUstate(other->c, copy)) == fmi2OK) {
        other->t = x->t;
        other->running = x->running;
    }
    CALL(OTHER, 0.0, fmi2FreeFMUstate(other->c, &copy));
    CALL(OTHER, 0.0, fmi2FreeFMUstate(x->c, &now));
    free(bytes);
}

static void other_call(instance *x) {
    const fmi2ValueReference ref = any_reference();
    fmi2Integer integer = 0;
    fmi2Boolean truth = 0;
    fmi2String text = NULL;
    double number = 0.0;
    static const fmi2String categories[] = {"logEvents", "logAll", "nonsense", "logStatusError"};
    switch (below(8)) {
    case 0:
        CALL(OTHER, 0.0, fmi2GetInteger(x->c, &ref, 1, &integer));
        break;
    case 1:
        CALL(OTHER, 0.0, fmi2SetBoolean(x->c, &ref, 1, &truth));
        break;
    case 2:
        CALL(OTHER, 0.0, fmi2GetStringStatus(x->c, fmi2PendingStatus, &text));
        break;
    case 3:
        CALL(OTHER, 0.0, fmi2GetBooleanStatus(x->c, fmi2Terminated, &truth));
        break;
    case 4:
        CALL(OTHER, 0.0, fmi2SetDebugLogging(x->c, fmi2True, 1, &categories[below(4)]));
        CALL(OTHER, 0.0, fmi2SetDebugLogging(x->c, fmi2True, 0, NULL));
        break;
    case 5:
        CALL(OTHER, 0.0, fmi2CancelStep(x->c));
        break;
    case 6:
        CALL(OTHER, 0.0, fmi2GetDirectionalDerivative(x->c, &ref, 1, &ref, 1, &number, &number));
        break;
    default:
        CALL(OTHER, 0.0, fmi2GetRealOutputDerivatives(x->c, &ref, 1, &integer, &number));
    }
}

static void once(instance *x, instance *other) {
    const int what = below(1000);
    if (what < 400)
        step(x);
    else if (what < 600)
        get_some(x);
    else if (what < 750)
        set_some(x, below(2) ? GB_FMU_INPUT : GB_FMU_PARAMETER);
    else if (what < 870)
        state(x);
    else if (what < 930)
        through_bytes(x, other);
    else if (what < 985)
        other_call(x);
    else if (what < 988)
        CALL(LIFE, 0.0, fmi2Terminate(x->c)), x->running = 0;
    else if (what < 991)
        CALL(BEGIN, 0.0, fmi2EnterInitializationMode(x->c));
    else if (what < 994)
        start_instance(x);
    else if (what < 997) {
        CALL(LIFE, 0.0, fmi2Reset(x->c));
        x->running = 0;
    } else {
        close_instance(x);
        memset(x, 0, sizeof *x);
        open_instance(x);
    }
    if (!x->running && below(4) == 0) {
        CALL(LIFE, 0.0, fmi2Reset(x->c));
        start_instance(x);
    }
}

int main(int argc, char **argv) {
    if (argc < 4)
        return 2;
    const long long calls = strtoll(argv[1], NULL, 10);
    instance x[INSTANCES];
    memset(x, 0, sizeof x);
    all.random = strtoull(argv[2], NULL, 10);
    all.limit = strtod(argv[3], NULL);
    all.share_of_long = argc > 4 ? strtol(argv[4], NULL, 10) : 100;
    for (int i = 0; i < INSTANCES; i++)
        open_instance(&x[i]);
    while (all.calls < calls && all.failures < 20) {
        const int i = below(INSTANCES);
        once(&x[i], &x[below(INSTANCES)]);
    }
    for (int i = 0; i < INSTANCES; i++)
        close_instance(&x[i]);
    printf("%lld calls, %lld of them wrong; status", all.calls, all.failures);
    for (int i = 0; i < 6; i++)
        printf(" %lld", all.statuses[i]);
    printf("\n");
    for (int k = 0; k < KINDS; k++)
        printf("%-6s %9lld calls, %9lld fmi2OK, longest %.3g s, mean %.3g us\n", kind_names[k], all.count[k],
               all.good[k], all.longest[k], all.count[k] > 0 ? 1e6 * all.sum[k] / (double)all.count[k] : 0.0);
    printf("longest step: of %g s\n", all.longest_h);
    return all.failures > 0;
}
