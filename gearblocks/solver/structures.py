"""Structures of gb_core.h in ctypes: codes, options, counters, reports, records."""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_double, c_int, c_long, c_longlong, c_void_p
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def address(values: NDArray[Any] | None) -> int | None:
    """Where the numbers of an array lie, None where there are none. numpy's own way takes five times as long."""
    if values is None or values.size == 0:
        return None
    if values.flags.writeable:
        return ctypes.addressof(ctypes.c_char.from_buffer(values.data))
    return values.ctypes.data


class Code(IntEnum):
    """What a call of the solver answers; negative: the run cannot go on."""

    DONE = 0
    FULL = 1
    PAUSE = 2
    ERR_STEP = -1
    ERR_NAN_RATE = -2
    ERR_NAN_INPUT = -3
    ERR_NAN_START = -4
    ERR_CHATTER = -5
    ERR_BRANCH = -6
    ERR_STATE = -7
    ERR_MEMORY = -8
    ERR_CALLBACK = -9
    ERR_SINGULAR = -10
    ERR_METHOD = -11
    ERR_LOSS = -12
    ERR_BEYOND = -13
    ERR_UNSTABLE = -14
    ERR_ESCAPE = -15
    ERR_JUMP = -16
    ERR_STALL = -17


CODES: dict[int, Code] = {code.value: code for code in Code}
"""By number: a look-up takes a fifth of what the enumeration's own takes."""


class Method(IntEnum):
    """Numbers of the integration methods."""

    RK4 = 0
    DP5 = 1
    DP8 = 2
    RODAS = 3
    AUTO = 4


class Kind(IntEnum):
    """How a table of input values is read between its points."""

    LINEAR = 1
    STEP = 2
    CUBIC = 3


class Options(ctypes.Structure):
    """gb_options."""

    _fields_ = [
        ("method", c_int),
        ("locate", c_int),
        ("rtol", c_double),
        ("step", c_double),
        ("max_step", c_double),
        ("t_stop", c_double),
    ]


class Counters(ctypes.Structure):
    """gb_stats."""

    _fields_ = [
        ("t", c_double),
        ("step", c_double),
        ("turnover", c_double),
        ("steps", c_longlong),
        ("rejected", c_longlong),
        ("rhs_calls", c_longlong),
        ("events", c_longlong),
        ("jacobians", c_longlong),
        ("steps_by", c_longlong * int(Method.AUTO)),
        ("method", c_int),
        ("n_switches", c_int),
        ("switch_method", c_int * 8),
        ("switch_t", c_double * 8),
    ]


class Report(ctypes.Structure):
    """gb_report."""

    _fields_ = [("code", c_int), ("index", c_int), ("t", c_double), ("value", c_double)]


class RecordStructure(ctypes.Structure):
    """gb_record."""

    _fields_ = [
        ("rows", c_void_p),
        ("n_rows", c_long),
        ("row_capacity", c_long),
        ("events", c_void_p),
        ("n_events", c_long),
        ("event_capacity", c_long),
        ("quantities", c_void_p),
        ("watches", c_void_p),
    ]


class WatchStructure(ctypes.Structure):
    """gb_watch."""

    _fields_ = [
        ("limit", c_double),
        ("count", c_longlong),
        ("first", c_double),
        ("least", c_double),
        ("largest", c_double),
        ("side", c_int),
        *((name, c_double) for name in ("t", "value", "known", "low", "high", "seen")),
    ]


class WatchesStructure(ctypes.Structure):
    """gb_watches."""

    _fields_ = [
        ("of", POINTER(WatchStructure)),
        ("output", c_void_p),
        ("count", c_int),
        ("from_event", c_int),
        ("room", c_void_p),
    ]


CAUSES = (
    "state", "massless", "ledger", "balance", "defect", "reach", "feature", "turn", "most", "event", "doubt", "time", "failure",
)  # fmt: skip
"""What can limit a step, by its number in gb_account."""


class AccountStructure(ctypes.Structure):
    """gb_account."""

    _fields_ = [
        ("accepted", c_longlong * len(CAUSES)),
        ("rejected", c_longlong * len(CAUSES)),
        ("accepted_by", c_void_p),
        ("rejected_by", c_void_p),
        ("size", c_int),
        ("cause", c_int),
    ]


class PointStructure(ctypes.Structure):
    """gb_point."""

    _fields_ = [("t", c_double), ("means", c_int), ("mode", c_void_p), ("input", c_void_p), ("rate", c_void_p)]


EVENT = np.dtype([("t", "f8"), ("before", "f8"), ("after", "f8"), ("index", "i4"), ("kind", "i4")], align=True)
"""gb_event: kind 0 is a state event, 1 a time event."""


InputFunction = ctypes.CFUNCTYPE(c_int, c_void_p, c_int, c_double, POINTER(c_double))
