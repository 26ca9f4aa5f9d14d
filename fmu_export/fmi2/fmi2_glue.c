/* FMI 2.0 for co-simulation: the standard's names over gb_fmu. Knows nothing of the solver. */
#include "fmi2_instance.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LOG_ERRORS = 1, LOG_EVENTS = 2, LOG_ALL = 4, LOG_WARNINGS = 8, LOG_DISCARDS = 16, LOG_EVERY = 31 };

static const char *const category_names[] = {"logStatusError", "logEvents", "logAll", "logStatusWarning",
                                             "logStatusDiscard"};

enum { N_CATEGORIES = sizeof category_names / sizeof category_names[0] };

/* ---- log ----------------------------------------------------------------------------------------------------- */

/* The logger takes a printf format: percent signs of the text are doubled, so that it stands for itself. */
static void say(const fmi2_instance *self, fmi2Status status, const char *category, const char *function,
                const char *text) {
    char message[640];
    size_t n = 0;
    for (int part = 0; part < 3; part++) {
        const char *from = part == 0 ? function : part == 1 ? ": " : text;
        for (; *from && n + 3 < sizeof message; from++) {
            if (*from == '%')
                message[n++] = '%';
            message[n++] = *from;
        }
    }
    message[n] = '\0';
    self->logger(self->environment, self->name, status, category, message);
}

fmi2Status fmi2_fail(const fmi2_instance *self, const char *function, const char *reason) {
    if (self->logger && (self->log & (LOG_ERRORS | LOG_ALL)))
        say(self, fmi2Error, "logStatusError", function, reason);
    return fmi2Error;
}

fmi2Status fmi2_answer(const fmi2_instance *self, const char *function, int code) {
    return code ? fmi2_fail(self, function, gb_fmu_message(self->fmu)) : fmi2OK;
}

/* The same for calls that may answer with a message that is no error. */
static fmi2Status answer_or(const fmi2_instance *self, const char *function, int code, fmi2Status status) {
    if (code <= 0)
        return fmi2_answer(self, function, code);
    const int bit = status == fmi2Warning ? LOG_WARNINGS : LOG_DISCARDS;
    if (self->logger && (self->log & (bit | LOG_ALL)))
        say(self, status, status == fmi2Warning ? "logStatusWarning" : "logStatusDiscard", function,
            gb_fmu_message(self->fmu));
    return status;
}

static void log_events(const fmi2_instance *self, long long events) {
    if (!self->logger || !(self->log & (LOG_EVENTS | LOG_ALL)) || events <= 0)
        return;
    char text[96];
    snprintf(text, sizeof text, "%lld events up to t = %.9g s", events, gb_fmu_time(self->fmu));
    say(self, fmi2OK, "logEvents", "fmi2DoStep", text);
}

fmi2Status FMI2_NAME(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String names[]) {
    fmi2_instance *self = c;
    if (!self || (count && !names))
        return fmi2Error;
    int mask = count ? 0 : LOG_EVERY;
    for (size_t i = 0; i < count; i++) {
        int bit = 0;
        for (int k = 0; k < N_CATEGORIES; k++)
            if (names[i] && strcmp(names[i], category_names[k]) == 0)
                bit = 1 << k;
        if (!bit)
            return fmi2_fail(
                self, "fmi2SetDebugLogging",
                "the categories are logStatusError, logStatusWarning, logStatusDiscard, logEvents and logAll");
        mask |= bit;
    }
    self->log = on ? self->log | mask : self->log & ~mask;
    return fmi2OK;
}

const char *FMI2_NAME(fmi2GetTypesPlatform)(void) {
    return "default";
}
const char *FMI2_NAME(fmi2GetVersion)(void) {
    return "2.0";
}

/* ---- life cycle ---------------------------------------------------------------------------------------------- */

static void refuse_instance(const fmi2CallbackFunctions *functions, const char *name, const char *reason) {
    if (functions && functions->logger)
        functions->logger(functions->componentEnvironment, name ? name : "", fmi2Error, "logStatusError", reason);
}

static char *copy_text(const char *text) {
    const size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    if (copy)
        memcpy(copy, text, size);
    return copy;
}

fmi2Component FMI2_NAME(fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                         const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean log) {
    (void)resources;
    (void)visible;
    const char *reason = NULL;
    if (!name || !*name)
        reason = "fmi2Instantiate: the instance needs a name";
    else if (type != fmi2CoSimulation)
        reason = "fmi2Instantiate: only co-simulation is packed into this FMU";
    else if (!guid || strcmp(guid, gb_fmu_the_table.token) != 0)
        reason = "fmi2Instantiate: the guid belongs to another export than this binary";
    char text[256];
    if (!reason && gb_fmu_missing()) {
        snprintf(text, sizeof text, "fmi2Instantiate: %s", gb_fmu_missing());
        reason = text;
    }
    if (reason) {
        refuse_instance(functions, name, reason);
        return NULL;
    }
    fmi2_instance *self = calloc(1, sizeof *self);
    if (self) {
        self->fmu = gb_fmu_open();
        self->name = copy_text(name);
    }
    if (!self || !self->fmu || !self->name) {
        refuse_instance(functions, name, "fmi2Instantiate: out of memory");
        FMI2_NAME(fmi2FreeInstance)(self);
        return NULL;
    }
    self->logger = functions ? functions->logger : NULL;
    self->environment = functions ? functions->componentEnvironment : NULL;
    self->log = log ? LOG_EVERY : LOG_ERRORS | LOG_WARNINGS | LOG_DISCARDS;
    return self;
}

void FMI2_NAME(fmi2FreeInstance)(fmi2Component c) {
    fmi2_instance *self = c;
    if (!self)
        return;
    gb_fmu_close(self->fmu);
    free(self->name);
    free(self);
}

fmi2Status FMI2_NAME(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                                          fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop) {
    fmi2_instance *self = c;
    if (!self)
        return fmi2Error;
    const int code = gb_fmu_setup(self->fmu, start, stop_defined ? &stop : NULL, tolerance_defined ? &tolerance : NULL);
    return answer_or(self, "fmi2SetupExperiment", code, fmi2Warning);
}

fmi2Status FMI2_NAME(fmi2EnterInitializationMode)(fmi2Component c) {
    fmi2_instance *self = c;
    return self ? fmi2_answer(self, "fmi2EnterInitializationMode", gb_fmu_initialize(self->fmu)) : fmi2Error;
}

fmi2Status FMI2_NAME(fmi2ExitInitializationMode)(fmi2Component c) {
    fmi2_instance *self = c;
    return self ? fmi2_answer(self, "fmi2ExitInitializationMode", gb_fmu_begin(self->fmu)) : fmi2Error;
}

fmi2Status FMI2_NAME(fmi2Terminate)(fmi2Component c) {
    fmi2_instance *self = c;
    return self ? fmi2_answer(self, "fmi2Terminate", gb_fmu_end(self->fmu)) : fmi2Error;
}

fmi2Status FMI2_NAME(fmi2Reset)(fmi2Component c) {
    fmi2_instance *self = c;
    return self ? fmi2_answer(self, "fmi2Reset", gb_fmu_reset(self->fmu)) : fmi2Error;
}

/* ---- variables: all are reals -------------------------------------------------------------------------------- */

fmi2Status FMI2_NAME(fmi2GetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    fmi2_instance *self = c;
    if (!self)
        return fmi2Error;
    if (n && (!vr || !value))
        return fmi2_fail(self, "fmi2GetReal", "references or values are NULL");
    return fmi2_answer(self, "fmi2GetReal", gb_fmu_get(self->fmu, vr, n, value));
}

fmi2Status FMI2_NAME(fmi2SetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    fmi2_instance *self = c;
    if (!self)
        return fmi2Error;
    if (n && (!vr || !value))
        return fmi2_fail(self, "fmi2SetReal", "references or values are NULL");
    return fmi2_answer(self, "fmi2SetReal", gb_fmu_set(self->fmu, vr, n, value));
}

static fmi2Status none_of_type(const fmi2_instance *self, const char *function, size_t n) {
    if (!self)
        return fmi2Error;
    return n ? fmi2_fail(self, function, "all variables of this FMU are reals; none has this value reference") : fmi2OK;
}

#define NO_SUCH_TYPE(name, type)                                                                                       \
    fmi2Status FMI2_NAME(name)(fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[]) {               \
        (void)vr;                                                                                                      \
        (void)value;                                                                                                   \
        return none_of_type(c, #name, n);                                                                              \
    }

NO_SUCH_TYPE(fmi2GetInteger, fmi2Integer)
NO_SUCH_TYPE(fmi2GetBoolean, fmi2Boolean)
NO_SUCH_TYPE(fmi2GetString, fmi2String)
NO_SUCH_TYPE(fmi2SetInteger, const fmi2Integer)
NO_SUCH_TYPE(fmi2SetBoolean, const fmi2Boolean)
NO_SUCH_TYPE(fmi2SetString, const fmi2String)

/* ---- stepping ------------------------------------------------------------------------------------------------ */

fmi2Status FMI2_NAME(fmi2DoStep)(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_earlier_state) {
    (void)no_earlier_state;
    fmi2_instance *self = c;
    if (!self)
        return fmi2Error;
    const int counted = self->log & (LOG_EVENTS | LOG_ALL);
    const long long before = counted ? gb_fmu_events(self->fmu) : 0;
    const fmi2Status status = answer_or(self, "fmi2DoStep", gb_fmu_step(self->fmu, time, step), fmi2Discard);
    if (counted && status == fmi2OK)
        log_events(self, gb_fmu_events(self->fmu) - before);
    return status;
}

fmi2Status FMI2_NAME(fmi2CancelStep)(fmi2Component c) {
    return c ? fmi2_fail(c, "fmi2CancelStep", "a step ends before its call returns; there is none to cancel")
             : fmi2Error;
}

static fmi2Status no_status(const fmi2_instance *self, const char *function) {
    return self ? fmi2_fail(self, function, "no step is pending and no such status is kept") : fmi2Error;
}

fmi2Status FMI2_NAME(fmi2GetStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)kind;
    (void)value;
    return no_status(c, "fmi2GetStatus");
}

fmi2Status FMI2_NAME(fmi2GetRealStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    fmi2_instance *self = c;
    if (!self || !value || kind != fmi2LastSuccessfulTime)
        return no_status(self, "fmi2GetRealStatus");
    *value = gb_fmu_time(self->fmu);
    return fmi2OK;
}

fmi2Status FMI2_NAME(fmi2GetIntegerStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)kind;
    (void)value;
    return no_status(c, "fmi2GetIntegerStatus");
}

fmi2Status FMI2_NAME(fmi2GetBooleanStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    fmi2_instance *self = c;
    if (!self || !value || kind != fmi2Terminated)
        return no_status(self, "fmi2GetBooleanStatus");
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status FMI2_NAME(fmi2GetStringStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    (void)kind;
    (void)value;
    return no_status(c, "fmi2GetStringStatus");
}
