/* An FMU as others make them: legal, and unlike those of gearblocks. An oscillator x' = v, v' = mu (1 - x^2) v - x by
 * steps of its own, whatever the communication step; a sum of inputs of every type.
 *
 * STRICT: values may be read from the initialization mode on, after an error only a reset or the end is taken.
 * LENIENT: takes every call, any guid, logs at any time. ENDS: ends the simulation itself after 3 s.
 * CRASHES, HANGS, EATS: no longer legal; what the first step does. LOADS: what loading does. Knows no header of
 * gearblocks: those of the standard are the importer's. */
#include "fmi2Functions.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "part.inc"

enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED, BROKEN };

typedef struct instance {
    int phase;
    double t, end, real[N_REALS];
    int integer, truth;
    char text[32];
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
} instance;

int written_by_all = 7; /* a global variable, exported */

static fmi2Status broken(instance *x, const char *what) {
    x->logger(x->environment, "foreign", fmi2Error, "logStatusError", "%s", what);
#ifdef STRICT
    x->phase = BROKEN;
#endif
    return fmi2Error;
}

/* The call is legal in the phases from `first` on. */
static int refused(instance *x, int first) {
#ifdef LENIENT
    (void)x;
    (void)first;
    return 0;
#else
    return x->phase < first || x->phase == BROKEN;
#endif
}

static void start(instance *x) {
    static const double values[N_REALS] = START;
    memcpy(x->real, values, sizeof values);
    x->integer = 3;
    x->truth = fmi2True;
    strcpy(x->text, "some text");
    x->phase = INSTANTIATED;
    x->t = x->end = 0.0;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String place,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    (void)name, (void)type, (void)place, (void)visible, (void)logging;
#ifndef LENIENT
    if (strcmp(guid, "{foreign}") != 0)
        return NULL;
#else
    (void)guid;
#endif
    instance *x = calloc(1, sizeof *x);
    x->logger = callbacks->logger;
    x->environment = callbacks->componentEnvironment;
    start(x);
#ifdef LENIENT
    x->logger(x->environment, "foreign", fmi2OK, "logAll", "here I am");
#endif
    return x;
}
void fmi2FreeInstance(fmi2Component c) {
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean defined, fmi2Real tolerance, fmi2Real begin,
                               fmi2Boolean stops, fmi2Real stop) {
    instance *x = c;
    (void)defined, (void)tolerance, (void)stops, (void)stop;
    x->t = x->end = begin;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    instance *x = c;
    if (x->phase != INSTANTIATED && refused(x, BROKEN + 1))
        return broken(x, "initialized twice");
    x->phase = INITIALIZING;
    return fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    ((instance *)c)->phase = STEPPING;
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) {
    ((instance *)c)->phase = TERMINATED;
    return fmi2OK;
}
fmi2Status fmi2Reset(fmi2Component c) {
    start(c);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean none) {
    instance *x = c;
    (void)t, (void)none;
    if (refused(x, STEPPING) || x->phase == TERMINATED)
        return broken(x, "a step now");
#ifndef LENIENT
    if (!(h > 0.0))
        return broken(x, "a step of nothing");
#endif
#ifdef CRASHES
    *(volatile int *)8 = 1;
#endif
#ifdef HANGS
    for (volatile int i = 0; i >= 0; i = 1)
        ;
#endif
#ifdef EATS
    for (;;)
        if (!memset(malloc(1u << 28), 1, 1u << 28))
            break;
#endif
#ifdef ENDS
    if (x->end + h > 3.0 + 1e-9)
        return fmi2Discard;
#endif
    x->end += h;
    while (x->t + OWN_STEP <= x->end + 1e-9 * OWN_STEP)
        advance(&x->t, x->real);
    return fmi2OK;
}

#define ACCESS(name, type, place, check)                                                                               \
    fmi2Status fmi2Get##name(fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[]) {                 \
        instance *x = c;                                                                                               \
        if (refused(x, INITIALIZING))                                                                                  \
            return broken(x, "read too early");                                                                        \
        for (size_t i = 0; i < n; i++) {                                                                               \
            if (!(check))                                                                                              \
                return broken(x, "no such variable");                                                                  \
            value[i] = place;                                                                                          \
        }                                                                                                              \
        return fmi2OK;                                                                                                 \
    }                                                                                                                  \
    fmi2Status fmi2Set##name(fmi2Component c, const fmi2ValueReference vr[], size_t n, const type value[]) {           \
        instance *x = c;                                                                                               \
        if (refused(x, INSTANTIATED))                                                                                  \
            return broken(x, "set after an error");                                                                    \
        for (size_t i = 0; i < n; i++) {                                                                               \
            if (!(check))                                                                                              \
                return broken(x, "no such variable");                                                                  \
            place = value[i];                                                                                          \
        }                                                                                                              \
        return fmi2OK;                                                                                                 \
    }
ACCESS(Real, fmi2Real, x->real[vr[i]], vr[i] < N_REALS)
ACCESS(Integer, fmi2Integer, x->integer, vr[i] == 0)
ACCESS(Boolean, fmi2Boolean, x->truth, vr[i] == 0)

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]) {
    (void)vr;
    for (size_t i = 0; i < n; i++)
        value[i] = ((instance *)c)->text;
    return fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]) {
    (void)vr;
    if (n)
        strncpy(((instance *)c)->text, value[0], sizeof((instance *)c)->text - 1);
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    if (!*state)
        *state = malloc(sizeof(instance));
    memcpy(*state, c, sizeof(instance));
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    memcpy(c, state, sizeof(instance));
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    (void)c;
    *value = kind == fmi2Terminated;
    return fmi2OK;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    (void)kind;
    *value = ((instance *)c)->end;
    return fmi2OK;
}
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[]) {
    (void)c, (void)on, (void)n, (void)names;
    return fmi2OK;
}
const char *fmi2GetTypesPlatform(void) {
    return fmi2TypesPlatform;
}
const char *fmi2GetVersion(void) {
    return fmi2Version;
}

/* What it has not. */
#define NOTHING(name, ...)                                                                                             \
    fmi2Status name(__VA_ARGS__) {                                                                                     \
        return fmi2Error;                                                                                              \
    }
NOTHING(fmi2SerializedFMUstateSize, fmi2Component c, fmi2FMUstate s, size_t *n)
NOTHING(fmi2SerializeFMUstate, fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n)
NOTHING(fmi2DeSerializeFMUstate, fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
NOTHING(fmi2GetDirectionalDerivative, fmi2Component c, const fmi2ValueReference u[], size_t n,
        const fmi2ValueReference k[], size_t m, const fmi2Real s[], fmi2Real v[])
NOTHING(fmi2SetRealInputDerivatives, fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Integer o[],
        const fmi2Real r[])
NOTHING(fmi2GetRealOutputDerivatives, fmi2Component c, const fmi2ValueReference v[], size_t n, const fmi2Integer o[],
        fmi2Real r[])
NOTHING(fmi2CancelStep, fmi2Component c)
NOTHING(fmi2GetStatus, fmi2Component c, const fmi2StatusKind k, fmi2Status *s)
NOTHING(fmi2GetIntegerStatus, fmi2Component c, const fmi2StatusKind k, fmi2Integer *s)
NOTHING(fmi2GetStringStatus, fmi2Component c, const fmi2StatusKind k, fmi2String *s)

#ifdef LOADS
__attribute__((constructor)) static void loaded(void) {
    FILE *trace = fopen(LOADS, "w");
    if (trace)
        fclose(trace);
}
#endif
