/* A master that knows the FMI headers and nothing of what is inside.
 *
 *     master LIBRARY GUID END STEP MODE REFERENCE...
 *
 * run:        prints time and values (as hexadecimal doubles) at every communication point; the last step ends at END.
 * restore:    saves half-way, runs to the end, restores, runs again, restores from bytes in a second instance, runs
 *             again; prints the last values, or fails where bits differ.
 * failures:   wrong calls; prints each one's status and log line.
 */
#define _POSIX_C_SOURCE 200809L
#include "fmi2.h"

#include <dlfcn.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_REFS = 64 };

static struct {
    fmi2Component (*instantiate)(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *,
                                 fmi2Boolean, fmi2Boolean);
    void (*free_instance)(fmi2Component);
    fmi2Status (*setup)(fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real);
    fmi2Status (*enter)(fmi2Component);
    fmi2Status (*leave)(fmi2Component);
    fmi2Status (*terminate)(fmi2Component);
    fmi2Status (*get)(fmi2Component, const fmi2ValueReference[], size_t, fmi2Real[]);
    fmi2Status (*set)(fmi2Component, const fmi2ValueReference[], size_t, const fmi2Real[]);
    fmi2Status (*step)(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);
    fmi2Status (*get_state)(fmi2Component, fmi2FMUstate *);
    fmi2Status (*set_state)(fmi2Component, fmi2FMUstate);
    fmi2Status (*free_state)(fmi2Component, fmi2FMUstate *);
    fmi2Status (*state_size)(fmi2Component, fmi2FMUstate, size_t *);
    fmi2Status (*to_bytes)(fmi2Component, fmi2FMUstate, fmi2Byte[], size_t);
    fmi2Status (*from_bytes)(fmi2Component, const fmi2Byte[], size_t, fmi2FMUstate *);
} fmi;

static char last_log[1024];

static void log_line(fmi2ComponentEnvironment env, fmi2String name, fmi2Status status, fmi2String category,
                     fmi2String message, ...) {
    va_list args;
    (void)env;
    (void)name;
    (void)status;
    (void)category;
    va_start(args, message);
    vsnprintf(last_log, sizeof last_log, message, args);
    va_end(args);
}

static const fmi2CallbackFunctions callbacks = {log_line, calloc, free, NULL, NULL};

static void die(const char *what) {
    fprintf(stderr, "%s: %s\n", what, last_log);
    exit(1);
}

static void check(fmi2Status status, const char *what) {
    if (status != fmi2OK)
        die(what);
}

static void load(void *library, const char *name, void *place) {
    void *symbol = dlsym(library, name);
    if (!symbol)
        die(name);
    memcpy(place, &symbol, sizeof symbol);
}

static void load_all(const char *path) {
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        die(dlerror());
    load(library, "fmi2Instantiate", &fmi.instantiate);
    load(library, "fmi2FreeInstance", &fmi.free_instance);
    load(library, "fmi2SetupExperiment", &fmi.setup);
    load(library, "fmi2EnterInitializationMode", &fmi.enter);
    load(library, "fmi2ExitInitializationMode", &fmi.leave);
    load(library, "fmi2Terminate", &fmi.terminate);
    load(library, "fmi2GetReal", &fmi.get);
    load(library, "fmi2SetReal", &fmi.set);
    load(library, "fmi2DoStep", &fmi.step);
    load(library, "fmi2GetFMUstate", &fmi.get_state);
    load(library, "fmi2SetFMUstate", &fmi.set_state);
    load(library, "fmi2FreeFMUstate", &fmi.free_state);
    load(library, "fmi2SerializedFMUstateSize", &fmi.state_size);
    load(library, "fmi2SerializeFMUstate", &fmi.to_bytes);
    load(library, "fmi2DeSerializeFMUstate", &fmi.from_bytes);
}

typedef struct plan {
    const char *guid;
    double end, h;
    size_t n;
    fmi2ValueReference refs[MAX_REFS];
} plan;

static fmi2Component begin(const plan *p, double stop) {
    fmi2Component c =
        fmi.instantiate("master", fmi2CoSimulation, p->guid, "file:///nowhere", &callbacks, fmi2False, fmi2False);
    if (!c)
        die("fmi2Instantiate");
    check(fmi.setup(c, fmi2False, 0.0, 0.0, stop > 0.0, stop), "fmi2SetupExperiment");
    check(fmi.enter(c), "fmi2EnterInitializationMode");
    check(fmi.leave(c), "fmi2ExitInitializationMode");
    return c;
}

/* Steps i = first .. until `end`; the last one is shortened. Returns the next i. */
static long go(fmi2Component c, const plan *p, long first, double end, int print, double *values) {
    long i = first;
    for (;; i++) {
        const double t = (double)i * p->h;
        const double next = (double)(i + 1) * p->h;
        const int last = next >= end - 1e-9 * p->h;
        if (print) {
            check(fmi.get(c, p->refs, p->n, values), "fmi2GetReal");
            printf("%a", t);
            for (size_t k = 0; k < p->n; k++)
                printf(" %a", values[k]);
            printf("\n");
        }
        check(fmi.step(c, t, (last ? end : next) - t, fmi2True), "fmi2DoStep");
        if (last)
            break;
    }
    check(fmi.get(c, p->refs, p->n, values), "fmi2GetReal");
    if (print) {
        printf("%a", end);
        for (size_t k = 0; k < p->n; k++)
            printf(" %a", values[k]);
        printf("\n");
    }
    return i + 1;
}

static void run(const plan *p) {
    double values[MAX_REFS];
    fmi2Component c = begin(p, p->end);
    go(c, p, 0, p->end, 1, values);
    check(fmi.terminate(c), "fmi2Terminate");
    fmi.free_instance(c);
}

static void restore(const plan *p) {
    double first[MAX_REFS], second[MAX_REFS], third[MAX_REFS];
    fmi2FMUstate state = NULL, copy = NULL;
    size_t size = 0;
    const long half = (long)(0.5 * p->end / p->h);
    fmi2Component c = begin(p, 0.0);
    fmi2Component other = begin(p, 0.0);
    go(c, p, 0, (double)half * p->h, 0, first);
    check(fmi.get_state(c, &state), "fmi2GetFMUstate");
    go(c, p, half, p->end, 0, first);
    check(fmi.set_state(c, state), "fmi2SetFMUstate");
    go(c, p, half, p->end, 0, second);
    check(fmi.state_size(c, state, &size), "fmi2SerializedFMUstateSize");
    fmi2Byte *bytes = malloc(size);
    if (!bytes)
        die("malloc");
    check(fmi.to_bytes(c, state, bytes, size), "fmi2SerializeFMUstate");
    check(fmi.from_bytes(other, bytes, size, &copy), "fmi2DeSerializeFMUstate");
    check(fmi.set_state(other, copy), "fmi2SetFMUstate");
    go(other, p, half, p->end, 0, third);
    if (memcmp(first, second, p->n * sizeof *first) || memcmp(first, third, p->n * sizeof *first))
        die("a restored run differs");
    for (size_t k = 0; k < p->n; k++)
        printf("%a\n", first[k]);
    check(fmi.free_state(c, &state), "fmi2FreeFMUstate");
    check(fmi.free_state(other, &copy), "fmi2FreeFMUstate");
    free(bytes);
    fmi.free_instance(c);
    fmi.free_instance(other);
}

static void tell(const char *what, fmi2Status status) {
    printf("%s | %d | %s\n", what, (int)status, last_log);
    last_log[0] = '\0';
}

static void failures(const plan *p) {
    const double nan_value = NAN, one = 1.0;
    double value;
    const fmi2ValueReference unknown = 0x7fffffffu;
    fmi2Component none = fmi.instantiate("x", fmi2CoSimulation, "wrong", "", &callbacks, fmi2False, fmi2False);
    tell("wrong guid", none ? fmi2OK : fmi2Error);
    none = fmi.instantiate("x", fmi2ModelExchange, p->guid, "", &callbacks, fmi2False, fmi2False);
    tell("model exchange", none ? fmi2OK : fmi2Error);
    fmi2Component c = begin(p, 0.0);
    check(fmi.step(c, 0.0, p->h, fmi2True), "fmi2DoStep");
    tell("zero", fmi.step(c, p->h, 0.0, fmi2True));
    tell("negative", fmi.step(c, p->h, -p->h, fmi2True));
    tell("nan", fmi.step(c, p->h, NAN, fmi2True));
    tell("nan time", fmi.step(c, NAN, p->h, fmi2True));
    tell("backward", fmi.step(c, 0.0, p->h, fmi2True));
    tell("unknown get", fmi.get(c, &unknown, 1, &value));
    tell("unknown set", fmi.set(c, &unknown, 1, &one));
    tell("nan value", fmi.set(c, &p->refs[0], 1, &nan_value));
    tell("enter", fmi.enter(c));
    tell("setup", fmi.setup(c, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    check(fmi.step(c, p->h, p->h, fmi2True), "fmi2DoStep");
    check(fmi.terminate(c), "fmi2Terminate");
    tell("after the end", fmi.step(c, 2.0 * p->h, p->h, fmi2True));
    fmi.free_instance(c);
}

int main(int argc, char **argv) {
    if (argc < 6 || argc - 6 > MAX_REFS)
        return 2;
    plan p = {argv[2], strtod(argv[3], NULL), strtod(argv[4], NULL), (size_t)(argc - 6), {0}};
    for (int i = 6; i < argc; i++)
        p.refs[i - 6] = (fmi2ValueReference)strtoul(argv[i], NULL, 10);
    load_all(argv[1]);
    if (strcmp(argv[5], "run") == 0)
        run(&p);
    else if (strcmp(argv[5], "restore") == 0)
        restore(&p);
    else
        failures(&p);
    return 0;
}
