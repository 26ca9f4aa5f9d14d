"""One running FMI 2.0 instance, driven through fmpy, with its log kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmu_export import manifest
from gearblocks.errors import ParameterError

OK, ERROR, FATAL = 0, 3, 4


@dataclass(frozen=True, slots=True)
class Unpacked:
    """An FMU unzipped into `folder`, and fmpy's reading of its description."""

    folder: Path
    description: Any

    @property
    def own(self) -> bool:
        """Whether gearblocks made it: more is asked of such FMUs than the standard asks."""
        return (self.folder / manifest.NAME).is_file() and (self.folder / "sources" / "model.c").is_file()


@dataclass(frozen=True, slots=True)
class Plan:
    """An FMU and the window in which its instances are run [s]."""

    unpacked: Unpacked
    begin: float
    stop: float
    steps: int

    @property
    def h(self) -> float:
        """The communication step: of FMUs of others the one that they ask for, if 64 of them lie in the window."""
        span, experiment = self.stop - self.begin, self.unpacked.description.defaultExperiment
        asked = None if self.unpacked.own or experiment is None else experiment.stepSize
        if asked is not None and 0.0 < 64 * float(asked) <= span:
            return float(asked)
        return span / self.steps if self.unpacked.own else span / max(self.steps, 64)

    @property
    def points(self) -> NDArray[np.float64]:
        """The communication points, as fmpy makes them."""
        count = round((self.stop - self.begin) / self.h)
        return np.array([min(self.begin + i * self.h, self.stop) for i in range(count + 1)])

    @property
    def tolerance(self) -> float:
        """That of the description."""
        experiment = self.unpacked.description.defaultExperiment
        return 1e-6 if experiment is None or experiment.tolerance is None else float(experiment.tolerance)

    def open(self, *, logging: bool = False) -> Instance:
        """A new instance."""
        return Instance(self.unpacked, logging=logging)


def times_of(description: Any, t_end: float | None) -> tuple[float, float]:
    """Start and end of the run [s]; ParameterError where t_end is not later than the start."""
    experiment = description.defaultExperiment
    begin = float(experiment.startTime or 0.0) if experiment is not None else 0.0
    stop = begin + 1.0
    if experiment is not None and experiment.stopTime is not None:
        stop = float(experiment.stopTime)
    stop = stop if t_end is None else t_end
    if not stop > begin:
        raise ParameterError(f"t_end = {stop!r} s must be later than the start at {begin!r} s")
    return begin, stop


class Instance:
    """A co-simulation instance, freed after the with block. `log`: (status, category, message) of every call."""

    def __init__(self, unpacked: Unpacked, *, token: str | None = None, logging: bool = False) -> None:
        from fmpy import calloc, fmi2, free
        from fmpy.logging import addLoggerProxy

        description = unpacked.description
        self.log: list[tuple[int, str, str]] = []
        self.fatal = False
        self.fmu: Any = fmi2.FMU2Slave(
            guid=description.guid if token is None else token,
            unzipDirectory=str(unpacked.folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="check",
        )
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(self._note)
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
        addLoggerProxy(fmi2.byref(callbacks))
        self.fmu.instantiate(callbacks=callbacks, loggingOn=logging)

    def _note(self, _environment: Any, _name: bytes, status: int, category: bytes, message: bytes) -> None:
        self.log.append((status, category.decode(errors="replace"), message.decode(errors="replace")))

    def __enter__(self) -> Instance:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not self.fatal:
            self.fmu.freeInstance()

    def start(self, t0: float = 0.0, stop: float | None = None, tolerance: float | None = None) -> None:
        """Experiment and initialization."""
        self.fmu.setupExperiment(tolerance=tolerance, startTime=t0, stopTime=stop)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def step(self, t: float, h: float) -> None:
        """One communication step."""
        self.fmu.doStep(currentCommunicationPoint=t, communicationStepSize=h)

    def get(self, references: Sequence[int]) -> list[float]:
        """Values of real variables."""
        return list(self.fmu.getReal(list(references)))

    def set(self, references: Sequence[int], values: Sequence[float]) -> None:
        """Sets real variables."""
        self.fmu.setReal(list(references), list(values))

    def refuses(self, call: Callable[[], object]) -> str:
        """The log line of a call that must answer an error; "" where it was accepted or said nothing."""
        before = len(self.log)
        status = self.status_of(call)
        return self.log[-1][2] if status == ERROR and len(self.log) > before else ""

    def status_of(self, call: Callable[[], object]) -> int:
        """What a call answers. After fmi2Fatal the instance may not even be freed."""
        from fmpy.fmi1 import FMICallException

        try:
            call()
        except FMICallException as error:
            self.fatal = self.fatal or error.status == FATAL
            return int(error.status)
        return OK
