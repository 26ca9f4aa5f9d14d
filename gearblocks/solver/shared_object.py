"""Shared objects: the core with the functions of gb_core.h and their types, and models, of which one function is seen."""

from __future__ import annotations

import ctypes
import functools
from ctypes import POINTER, c_double, c_int, c_long, c_size_t, c_void_p
from typing import Any

from gearblocks.errors import CompileError
from gearblocks.solver.step_matrix import PROTOTYPES
from gearblocks.solver.structures import (
    AccountStructure,
    Counters,
    InputFunction,
    Options,
    PointStructure,
    RecordStructure,
    Report,
    WatchesStructure,
)
from gearblocks.solver.switched_constraints import PROTOTYPES as CONSTRAINT_PROTOTYPES

_PROTOTYPES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "gb_open": (c_void_p, (c_void_p,)),
    "gb_close": (None, (c_void_p,)),
    "gb_parameters": (c_void_p, (c_void_p,)),
    "gb_inputs": (c_void_p, (c_void_p,)),
    "gb_changed": (None, (c_void_p,)),
    "gb_input_table": (c_int, (c_void_p, c_int, c_int, c_int, c_void_p, c_void_p, c_void_p, c_double)),
    "gb_input_callback": (None, (c_void_p, c_int, InputFunction, c_void_p)),
    "gb_start": (c_int, (c_void_p, POINTER(Options), c_double, c_void_p)),
    "gb_advance": (c_int, (c_void_p, c_double)),
    "gb_time": (c_double, (c_void_p,)),
    "gb_state": (c_int, (c_void_p, c_void_p)),
    "gb_outputs": (c_int, (c_void_p, c_void_p)),
    "gb_energies": (c_int, (c_void_p, c_void_p)),
    "gb_rounding_energy": (c_double, (c_void_p,)),
    "gb_run": (c_int, (c_void_p, c_void_p, c_long, c_double, POINTER(RecordStructure), c_double)),
    "gb_evaluate": (c_int, (c_void_p, c_void_p, c_long, c_void_p, c_int, c_void_p, c_void_p)),
    "gb_quantity_room": (c_size_t, (c_void_p, c_int)),
    "gb_keep_account": (None, (c_void_p, POINTER(AccountStructure))),
    "gb_watch_room": (c_size_t, (c_void_p, c_int)),
    "gb_watches_begin": (None, (POINTER(WatchesStructure),)),
    "gb_study_run": (c_int, (c_void_p, c_void_p, c_double)),
    "gb_tangent_size": (c_size_t, (c_void_p, c_int)),
    "gb_tangents_run": (c_int, (c_void_p, c_void_p, c_double)),
    "gb_rhs": (c_int, (c_void_p, c_double, c_void_p, c_void_p)),
    "gb_probe": (c_int, (c_void_p, POINTER(PointStructure), *(c_void_p,) * 6)),
    "gb_snapshot_size": (c_size_t, (c_void_p,)),
    "gb_save": (None, (c_void_p, c_void_p)),
    "gb_restore": (c_int, (c_void_p, c_void_p)),
    "gb_get_stats": (None, (c_void_p, POINTER(Counters))),
    "gb_get_report": (None, (c_void_p, POINTER(Report))),
}


@functools.cache
def open_core(path: str) -> ctypes.CDLL:
    """Loads the core and gives its functions their types, once in a process. Raises CompileError where it is none of ours."""
    try:
        handle = ctypes.CDLL(path)
        for name, (result, arguments) in (_PROTOTYPES | PROTOTYPES | CONSTRAINT_PROTOTYPES).items():
            function = getattr(handle, name)
            function.restype, function.argtypes = result, arguments
    except (OSError, AttributeError) as error:
        raise CompileError(f"the compiled solver {path} cannot be loaded: {error}") from error
    return handle


def open_model(path: str) -> tuple[ctypes.CDLL, int]:
    """Loads a model: its handle, which stays as long as the model is used, and the address of its gb_model. Raises
    CompileError where it is none of ours."""
    try:
        handle = ctypes.CDLL(path)
        handle.gb_get_model.restype, handle.gb_get_model.argtypes = c_void_p, ()
        return handle, int(handle.gb_get_model())
    except (OSError, AttributeError) as error:
        raise CompileError(f"the compiled model {path} cannot be loaded: {error}") from error
