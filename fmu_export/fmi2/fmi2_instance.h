/* What the files of the FMI 2.0 glue share. */
#ifndef GB_FMI2_INSTANCE_H
#define GB_FMI2_INSTANCE_H

#include "fmi2.h"

#include "gb_fmu.h"

typedef struct fmi2_instance {
    gb_fmu *fmu;
    char *name;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    int log;
} fmi2_instance;

/* Logs what was refused and answers fmi2Error. */
fmi2Status fmi2_fail(const fmi2_instance *self, const char *function, const char *reason);

/* fmi2OK for 0, else fmi2_fail with the reason that gb_fmu keeps. */
fmi2Status fmi2_answer(const fmi2_instance *self, const char *function, int code);

#endif
