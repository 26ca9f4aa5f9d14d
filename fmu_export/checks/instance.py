"""One running FMI 2.0 instance, driven through fmpy, with its log kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

OK, ERROR = 0, 3


@dataclass(frozen=True, slots=True)
class Unpacked:
    """An FMU unzipped into `folder`, and fmpy's reading of its description."""

    folder: Path
    description: Any


class Instance:
    """A co-simulation instance, freed after the with block. `log`: (status, category, message) of every call."""

    def __init__(self, unpacked: Unpacked, *, token: str | None = None, logging: bool = False) -> None:
        from fmpy import calloc, fmi2, free
        from fmpy.logging import addLoggerProxy

        description = unpacked.description
        self.log: list[tuple[int, str, str]] = []
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
        from fmpy.fmi1 import FMICallException

        before = len(self.log)
        try:
            call()
        except FMICallException as error:
            if error.status == ERROR and len(self.log) > before:
                return self.log[-1][2]
        return ""
