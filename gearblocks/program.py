"""The generated program of one train: C text and the names of everything in its vectors.

Plain frozen values that can be stored and printed. Reading a stored program needs neither sympy nor jinja.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Quantity:
    """Name, SI unit and description of one number in a vector."""

    name: str
    unit: str
    words: str


@dataclass(frozen=True, slots=True)
class ParameterInfo:
    """One entry of the parameter vector. `tunable` is False for start values, which are fixed once a run has begun."""

    path: str
    unit: str
    words: str
    lower: float | None
    upper: float | None
    tunable: bool


@dataclass(frozen=True, slots=True)
class InputInfo:
    """One entry of the input vector, with its unit and its value before anything is connected."""

    name: str
    unit: str
    start: float


@dataclass(frozen=True, slots=True)
class SwitchInfo:
    """One located switch: the component that owns it and whether state or time alone moves it.

    low, high: what the events show for modes 0 and 1.
    """

    component: str
    name: str
    kind: str
    low: float = 0.0
    high: float = 1.0


@dataclass(frozen=True, slots=True)
class EnergyInfo:
    """One stored energy: `part` is "kinetic" or "stored"; `index` points into the vector of energies."""

    component: str
    part: str
    index: int


@dataclass(frozen=True, slots=True)
class IntegralInfo:
    """One tail state: `part` is "loss", "supplied" or "angle"; `index` points into the state vector."""

    component: str
    part: str
    index: int


@dataclass(frozen=True, slots=True)
class StartInfo:
    """An initial value by the name of an output ("motor.w"): parameter `index` takes value * factor."""

    name: str
    index: int
    factor: float


@dataclass(frozen=True, slots=True)
class Program:
    """C source of one `gb_model` with the meaning of its vectors.

    n, n_padded, n_total: lengths of the state vector as in c/gb_model.h.
    structural: values of parameters that the structure rests on (ratios); another value needs another program.
    """

    name: str
    source: str
    key: str
    parameters: tuple[ParameterInfo, ...]
    inputs: tuple[InputInfo, ...]
    states: tuple[Quantity, ...]
    switches: tuple[SwitchInfo, ...]
    outputs: tuple[Quantity, ...]
    energies: tuple[EnergyInfo, ...]
    integrals: tuple[IntegralInfo, ...]
    n: int
    n_padded: int
    n_total: int
    starts: tuple[StartInfo, ...] = ()
    structural: tuple[tuple[str, float], ...] = ()
