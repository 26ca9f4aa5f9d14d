/* FMI 2.0: saved states, and the derivatives that this FMU does not provide. */
#include "fmi2_instance.h"

#include <stdlib.h>
#include <string.h>

typedef struct saved_state {
    size_t size; /* of the block that follows */
} saved_state;

/* ---- derivatives: declared as not provided ------------------------------------------------------------------- */

fmi2Status FMI2_NAME(fmi2GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference unknown[],
                                                   size_t n_unknown, const fmi2ValueReference known[], size_t n_known,
                                                   const fmi2Real seed[], fmi2Real sensitivity[]) {
    (void)unknown;
    (void)n_unknown;
    (void)known;
    (void)n_known;
    (void)seed;
    (void)sensitivity;
    return c ? fmi2_fail(c, "fmi2GetDirectionalDerivative", "directional derivatives are not provided") : fmi2Error;
}

fmi2Status FMI2_NAME(fmi2SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                                  const fmi2Integer order[], const fmi2Real value[]) {
    (void)vr;
    (void)n;
    (void)order;
    (void)value;
    return c ? fmi2_fail(c, "fmi2SetRealInputDerivatives", "inputs are held constant over a step") : fmi2Error;
}

fmi2Status FMI2_NAME(fmi2GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                                   const fmi2Integer order[], fmi2Real value[]) {
    (void)vr;
    (void)n;
    (void)order;
    (void)value;
    return c ? fmi2_fail(c, "fmi2GetRealOutputDerivatives", "derivatives of outputs are not provided") : fmi2Error;
}

/* ---- saved states: a size and the block behind it ------------------------------------------------------------ */

static void *block_of(saved_state *saved) {
    return saved + 1;
}

static saved_state *new_state(size_t size) {
    saved_state *saved = malloc(sizeof *saved + size);
    if (saved)
        saved->size = size;
    return saved;
}

fmi2Status FMI2_NAME(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *state) {
    fmi2_instance *self = c;
    if (!self)
        return fmi2Error;
    if (!state)
        return fmi2_fail(self, "fmi2GetFMUstate", "the place for the state is NULL");
    const size_t size = gb_fmu_block_size(self->fmu);
    saved_state *saved = *state;
    if (saved && saved->size != size)
        return fmi2_fail(self, "fmi2GetFMUstate", "the state given for re-use belongs to another model");
    if (!saved)
        saved = new_state(size);
    if (!saved)
        return fmi2_fail(self, "fmi2GetFMUstate", "out of memory");
    gb_fmu_save(self->fmu, block_of(saved));
    *state = saved;
    return fmi2OK;
}

fmi2Status FMI2_NAME(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state) {
    fmi2_instance *self = c;
    if (!self)
        return fmi2Error;
    if (!state)
        return fmi2_fail(self, "fmi2SetFMUstate", "the state is NULL");
    saved_state *saved = state;
    if (gb_fmu_fits(self->fmu, block_of(saved), saved->size))
        return fmi2_answer(self, "fmi2SetFMUstate", -1);
    return fmi2_answer(self, "fmi2SetFMUstate", gb_fmu_restore(self->fmu, block_of(saved)));
}

fmi2Status FMI2_NAME(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *state) {
    if (!c)
        return fmi2Error;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status FMI2_NAME(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state, size_t *size) {
    if (!c)
        return fmi2Error;
    if (!state || !size)
        return fmi2_fail(c, "fmi2SerializedFMUstateSize", "the state or the place for its size is NULL");
    *size = ((saved_state *)state)->size;
    return fmi2OK;
}

fmi2Status FMI2_NAME(fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    if (!c)
        return fmi2Error;
    saved_state *saved = state;
    if (!saved || !bytes || size < saved->size)
        return fmi2_fail(c, "fmi2SerializeFMUstate", "the state is NULL or the place for its bytes too small");
    memcpy(bytes, block_of(saved), saved->size);
    return fmi2OK;
}

fmi2Status FMI2_NAME(fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                              fmi2FMUstate *state) {
    fmi2_instance *self = c;
    if (!self)
        return fmi2Error;
    if (!bytes || !state)
        return fmi2_fail(self, "fmi2DeSerializeFMUstate", "the bytes or the place for the state are NULL");
    if (gb_fmu_fits(self->fmu, bytes, size))
        return fmi2_answer(self, "fmi2DeSerializeFMUstate", -1);
    saved_state *saved = new_state(size);
    if (!saved)
        return fmi2_fail(self, "fmi2DeSerializeFMUstate", "out of memory");
    memcpy(block_of(saved), bytes, size);
    *state = saved;
    return fmi2OK;
}
