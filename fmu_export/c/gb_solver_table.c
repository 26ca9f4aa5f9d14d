/* Compiled once for each kind of processor, together with the solver and the model. */
#include "gb_solver.h"

const gb_solver gb_solver_plain = {
    .get_model = gb_get_model,
    .open = gb_open,
    .close = gb_close,
    .model_of = gb_model_of,
    .parameters = gb_parameters,
    .inputs = gb_inputs,
    .changed = gb_changed,
    .start = gb_start,
    .advance_within = gb_advance_within,
    .time = gb_time,
    .outputs = gb_outputs,
    .snapshot_size = gb_snapshot_size,
    .save = gb_save,
    .fits = gb_fits,
    .restore = gb_restore,
    .checksum = gb_checksum,
    .get_stats = gb_get_stats,
    .get_report = gb_get_report,
};
