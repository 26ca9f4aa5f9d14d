"""Many points of one model side by side in the lanes of vectors: fixed steps of the classical Runge-Kutta method, sides of
contacts by selects (c/gb_lane_run.h).

Bits are those of single runs with method "rk4" that locate nothing, whatever the number of points, their order and the
registers of the machine. Lanes screen; runs that locate confirm. Knows nothing of what the points belong to.
"""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from ctypes import POINTER, c_double, c_int, c_long, c_size_t, c_void_p
from dataclasses import dataclass

import numpy as np

from gearblocks.codegen.program import Program
from gearblocks.errors import CompileError
from gearblocks.plurals import singular
from gearblocks.solver.cache import digest, user_cache
from gearblocks.solver.compiler import FLAGS, SHARED_SUFFIX, cpu_identity
from gearblocks.solver.library import Model, compiler_here, headers_of, produced
from gearblocks.solver.structures import Array, address

POINTS = 32
"""Points side by side: GB_LANE_POINTS of gb_lane.h."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LaneSteps:
    """What all points have in common: `steps` steps from t_start on, each as long as its point says.

    period: steps after which every excitation by time repeats (0: not known; more than 2048 are not kept). first: step from
    which outputs count; their samples are taken every `stride` steps from there (0: none). every: whether outputs are looked
    at after every step, for extremes and means.
    """

    steps: int
    t_start: float = 0.0
    period: int = 0
    first: int = 0
    stride: int = 0
    every: bool = True

    @property
    def n_samples(self) -> int:
        """Rows of samples."""
        return (self.steps - self.first) // self.stride + 1 if self.stride else 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LaneResult:
    """By point: largest, least, mean and root mean square of each output over the steps that count (means by the trapezoidal
    rule; all of them zeros where not every step was looked at), shape (points, outputs); samples (points, rows, outputs); the
    last state (points, n)."""

    largest: Array
    least: Array
    mean: Array
    rms: Array
    samples: Array
    last: Array

    def __repr__(self) -> str:
        return singular(f"<LaneResult: {len(self.last)} points, {self.largest.shape[1]} outputs>")


class _Job(ctypes.Structure):
    """gb_lane_job."""

    _fields_ = [
        ("t_start", c_double),
        ("steps", c_long),
        ("period", c_long),
        ("from", c_long),
        ("stride", c_long),
        *((name, c_void_p) for name in ("step", "parameters", "largest", "least", "sum", "square", "samples", "last")),
        ("memory", c_void_p),
    ]


_PROTOTYPES = {
    "gb_lane_memory": (c_size_t, ()),
    "gb_lane_points": (c_int, ()),
    "gb_lanes_run": (None, (c_void_p, c_void_p, POINTER(_Job))),
}


class Lanes:
    """The compiled lanes of a model for some of its outputs. Raises CompileError; `model.program.lanes` says whether
    there are any."""

    def __init__(self, model: Model, outputs: Sequence[int]) -> None:
        self._model, self._n_outputs = model, len(outputs)
        self._shared = _compiled(model.program, tuple(outputs))
        self._native = model.library.native
        self.points = int(self._shared.gb_lane_points())

    def run(self, parameters: Array, step: Array, inputs: Array, how: LaneSteps, threads: int = 1) -> LaneResult:
        """Runs all points. parameters: their vectors, shape (points, parameters); step: [s], shape (points,); inputs: their
        constant values. Where the excitation does not repeat after how.period, it is computed step by step."""
        blocks = range(0, len(step), self.points)

        def block(first: int) -> tuple[Array, ...]:
            last = min(first + self.points, len(step))
            chosen = np.minimum(np.arange(first, first + self.points), last - 1)
            return tuple(part[: last - first] for part in self._block(parameters[chosen], step[chosen], inputs, how))

        if threads > 1 and len(blocks) > 1:
            with ThreadPoolExecutor(max_workers=threads) as workers:
                found = [*workers.map(block, blocks)]
        else:
            found = [block(first) for first in blocks]
        return LaneResult(**dict(zip(LaneResult.__slots__, map(np.concatenate, zip(*found, strict=True)), strict=True)))

    def _block(self, parameters: Array, step: Array, inputs: Array, how: LaneSteps) -> tuple[Array, ...]:
        """Largest, least, mean, rms, samples, last of as many points as there are lanes."""
        n, points = self._n_outputs, self.points
        parameters, step = np.ascontiguousarray(parameters), np.ascontiguousarray(step)
        inputs = np.ascontiguousarray(np.append(inputs, 0.0))
        largest, least, total, square = np.zeros((4, n, points))
        samples, last = np.zeros((how.n_samples, n, points)), np.zeros((points, self._model.program.n))
        memory = np.empty(self._shared.gb_lane_memory() + 64, dtype=np.uint8)
        start = memory.ctypes.data
        job = _Job(
            how.t_start, how.steps, how.period, how.first, how.stride, address(step), address(parameters),
            *(address(part) if how.every else None for part in (largest, least, total, square)), address(samples),
            address(last), start + -start % 64,
        )  # fmt: skip
        self._shared.gb_lanes_run(self._native, address(inputs), ctypes.byref(job))
        count = how.steps - how.first
        with np.errstate(invalid="ignore", over="ignore"):  # points that blow up
            mean, rms = total / count, np.sqrt(square / count)
        return largest.T, least.T, mean.T, rms.T, samples.transpose(2, 0, 1), last

    def __repr__(self) -> str:
        return singular(f"<Lanes of '{self._model.program.name}': {self.points} points, {self._n_outputs} outputs>")


@functools.lru_cache(maxsize=64)
def _library(path: str) -> ctypes.CDLL:
    shared = ctypes.CDLL(path)
    for name, (result, arguments) in _PROTOTYPES.items():
        function = getattr(shared, name)
        function.restype, function.argtypes = result, arguments
    return shared


def _compiled(program: Program, outputs: tuple[int, ...]) -> ctypes.CDLL:
    """The shared object for these outputs, from the cache where it was compiled before."""
    if not program.lanes:
        raise CompileError(f"'{program.name}' has no lanes: its sides do not follow from the state alone")
    numbers = ", ".join(map(str, outputs or (0,)))
    picks = f"enum {{ N_PICKS = {len(outputs)} }};\nstatic const int lane_pick[] = {{{numbers}}};\n"
    source, compiler, cache = program.lanes.encode(), compiler_here(), user_cache()
    files = {**headers_of(source), "lanes.c": source, "lane_picks.h": picks.encode()}
    flags = (*FLAGS, *compiler.native, "-shared", "lanes.c", "-o", "lanes" + SHARED_SUFFIX, "-lm")
    key = digest(
        "lanes", compiler.identity, cpu_identity(), *flags, *(part for item in sorted(files.items()) for part in item)
    )
    path = cache.find("lanes", key, SHARED_SUFFIX)
    if path is None:
        path = cache.write("lanes", key, produced(compiler, files, flags, "lanes" + SHARED_SUFFIX), SHARED_SUFFIX)
    return _library(str(path))
