/* Names and types of FMI 2.0 (co-simulation and what both kinds share), as the standard lays them down.
 *
 * In a shared library the functions carry their plain names. Whoever links several FMUs statically compiles the sources
 * with FMI2_FUNCTION_PREFIX set to the model identifier and an underscore.
 */
#ifndef GB_FMI2_H
#define GB_FMI2_H

#include <stddef.h>

#ifdef FMI2_FUNCTION_PREFIX
#define FMI2_JOIN_(a, b) a##b
#define FMI2_JOIN(a, b) FMI2_JOIN_(a, b)
#define FMI2_NAME(name) FMI2_JOIN(FMI2_FUNCTION_PREFIX, name)
#else
#define FMI2_NAME(name) name
#endif

#if defined(_WIN32)
#define FMI2_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define FMI2_EXPORT __attribute__((visibility("default")))
#else
#define FMI2_EXPORT
#endif

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Char;
typedef const fmi2Char *fmi2String;
typedef char fmi2Byte;

enum { fmi2False = 0, fmi2True = 1 };

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

typedef void (*fmi2CallbackLogger)(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                                   fmi2String category, fmi2String message, ...);
typedef void *(*fmi2CallbackAllocateMemory)(size_t count, size_t size);
typedef void (*fmi2CallbackFreeMemory)(void *memory);
typedef void (*fmi2StepFinished)(fmi2ComponentEnvironment environment, fmi2Status status);

typedef struct {
    fmi2CallbackLogger logger;
    fmi2CallbackAllocateMemory allocateMemory;
    fmi2CallbackFreeMemory freeMemory;
    fmi2StepFinished stepFinished;
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

#define FMI2_FN(type, name) FMI2_EXPORT type FMI2_NAME(name)

FMI2_FN(const char *, fmi2GetTypesPlatform)(void);
FMI2_FN(const char *, fmi2GetVersion)(void);
FMI2_FN(fmi2Status, fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String names[]);

/* Life cycle. */
FMI2_FN(fmi2Component, fmi2Instantiate)(fmi2String instance, fmi2Type type, fmi2String guid, fmi2String resources,
                                        const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean log);
FMI2_FN(void, fmi2FreeInstance)(fmi2Component c);
FMI2_FN(fmi2Status, fmi2SetupExperiment)(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                                         fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop);
FMI2_FN(fmi2Status, fmi2EnterInitializationMode)(fmi2Component c);
FMI2_FN(fmi2Status, fmi2ExitInitializationMode)(fmi2Component c);
FMI2_FN(fmi2Status, fmi2Terminate)(fmi2Component c);
FMI2_FN(fmi2Status, fmi2Reset)(fmi2Component c);

/* Variables. */
FMI2_FN(fmi2Status, fmi2GetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]);
FMI2_FN(fmi2Status, fmi2GetInteger)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]);
FMI2_FN(fmi2Status, fmi2GetBoolean)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]);
FMI2_FN(fmi2Status, fmi2GetString)(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]);
FMI2_FN(fmi2Status, fmi2SetReal)(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]);
FMI2_FN(fmi2Status, fmi2SetInteger)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                    const fmi2Integer value[]);
FMI2_FN(fmi2Status, fmi2SetBoolean)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                    const fmi2Boolean value[]);
FMI2_FN(fmi2Status, fmi2SetString)(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]);

/* The whole state. */
FMI2_FN(fmi2Status, fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *state);
FMI2_FN(fmi2Status, fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state);
FMI2_FN(fmi2Status, fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *state);
FMI2_FN(fmi2Status, fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state, size_t *size);
FMI2_FN(fmi2Status, fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size);
FMI2_FN(fmi2Status, fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state);

/* Derivatives: declared as not provided. */
FMI2_FN(fmi2Status, fmi2GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                                  const fmi2ValueReference known[], size_t n_known,
                                                  const fmi2Real seed[], fmi2Real sensitivity[]);
FMI2_FN(fmi2Status, fmi2SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                                 const fmi2Integer order[], const fmi2Real value[]);
FMI2_FN(fmi2Status, fmi2GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                                  const fmi2Integer order[], fmi2Real value[]);

/* Stepping. */
FMI2_FN(fmi2Status, fmi2DoStep)(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_earlier_state);
FMI2_FN(fmi2Status, fmi2CancelStep)(fmi2Component c);
FMI2_FN(fmi2Status, fmi2GetStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value);
FMI2_FN(fmi2Status, fmi2GetRealStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value);
FMI2_FN(fmi2Status, fmi2GetIntegerStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value);
FMI2_FN(fmi2Status, fmi2GetBooleanStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value);
FMI2_FN(fmi2Status, fmi2GetStringStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2String *value);

#endif
