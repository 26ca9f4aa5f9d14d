"""The generated program of one train: C text and the names of everything in its vectors.

Plain frozen values that can be stored and printed. Reading a stored program needs neither sympy nor jinja.
"""

from __future__ import annotations

import io
import pickle
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.output_list import OutputList, Quantity

POWER_INTO_FLANGE = "power from the block into the flange"
"""Words of the outputs by which a block gives power."""


class ParameterInfo(NamedTuple):
    """One entry of the parameter vector. `tunable` is False for start values, which are fixed once a run has begun.

    start: what a start value is of: "angle" or "speed" of a shaft, or "state" of a block. open_lower, open_upper: the
    bound itself is no value of it (> lower, < upper). given_in: the unit that values are given in, where that is none of SI.
    why: what is said behind a bound that is broken.
    """

    path: str
    unit: str
    words: str
    lower: float | None
    upper: float | None
    tunable: bool
    start: str = ""
    open_lower: bool = False
    open_upper: bool = False
    given_in: str = ""
    why: str = ""


class InputInfo(NamedTuple):
    """One entry of the input vector, with its unit and its value before anything is connected, both of SI.

    given_in: the unit that values are given in, where that is none of SI.
    """

    name: str
    unit: str
    start: float
    given_in: str = ""


class SwitchInfo(NamedTuple):
    """One located switch: the component that owns it and whether state or time alone moves it.

    low, high: what the events show for modes 0 and 1.
    """

    component: str
    name: str
    kind: str
    low: float = 0.0
    high: float = 1.0


class EnergyInfo(NamedTuple):
    """One stored energy: `part` is "kinetic" or "stored"; `offset` is its place in the vector of energies."""

    component: str
    part: str
    offset: int


class IntegralInfo(NamedTuple):
    """One quadrature: `part` is "loss", "supplied" or "angle"; `offset` is its place in the state vector."""

    component: str
    part: str
    offset: int


class HeatInfo(NamedTuple):
    """Heat that the state at `offset` counts: from the ThermalMass `source` to `sink`; source "": what the component loses, or
    surroundings; sink "": surroundings."""

    component: str
    offset: int
    source: str
    sink: str
    is_loss: bool


class StartInfo(NamedTuple):
    """An initial value by the name of an output ("motor.w"): the parameter at `offset` takes value * factor.

    of: "angle" or "speed" of a shaft, or "state" of a block.
    """

    name: str
    offset: int
    factor: float
    of: str = ""


LOSSY = "lossy"
LOSSY_VARYING = "lossy, by gains that vary"


class DependentStart(NamedTuple):
    """A start value that follows from others through rigid constraints: the sum of factors times the parameters at `offsets`.

    of: "angle" or "speed"; LOSSY: the slip of a lossy tie, which must be 0; LOSSY_VARYING: the same where the gains follow from
    the angles, with all independent speeds by their number.
    """

    name: str
    offsets: tuple[int, ...]
    factors: tuple[float, ...]
    of: str = ""


class PrescribedStart(NamedTuple):
    """A start value of a shaft whose motion something else gives: its name, the output that shows it, and what gives it, in
    words; tied: by a prescribed motion, so that others depend on it; of: "angle" or "speed"."""

    name: str
    output: str
    by: str
    tied: bool
    of: str = ""


class GroupStart(NamedTuple):
    """A group of shafts that no rigid constraint determines: the parameters at `angle` and `speed` (-1: there is none) are its
    angle and speed times the gains.

    output: an output that shows its speed, as `output_gain` times that; prescribed: something moves it, by an angle or a speed
    of its own; varying: a relation moves it whose gain is no number.
    """

    angle: int
    angle_gain: float
    speed: int
    speed_gain: float
    output: str
    output_gain: float
    prescribed: bool
    varying: bool


class RigidRow(NamedTuple):
    """A form over angles of groups, sum of factor * phi + sum of offset factor * parameter; its rate without the latter.

    component: a body, whose angle it is, with the names of its start angle and speed and whether it gives them; or a
    compliant element, whose deflection it is, and whether it gives that at the start or its rate; or a switched constraint,
    whose slip it is. rest, lower, upper: of an element
    the parameters that say where it carries nothing (-1: there is none; UNKNOWN: it is no parameter by itself), times scale.
    varying: it is so for the mean ratio alone.
    """

    component: str
    groups: tuple[int, ...]
    factors: tuple[float, ...]
    offsets: tuple[int, ...]
    offset_factors: tuple[float, ...]
    angle: str = ""
    speed: str = ""
    gives_angle: bool = False
    gives_speed: bool = False
    gives_acceleration: bool = False
    rest: int = -1
    lower: int = -1
    upper: int = -1
    scale: float = 1.0
    varying: bool = False


class AlgebraicSlip(NamedTuple):
    """A constraint whose force is algebraic, as a shaft without inertia needs it: component, groups and factors of its slip as
    of a RigidRow; tie: a lossy gear's, which is held always. switches: two of which the event functions, where it is stuck,
    are force - bound and -force - bound (-1: no bound that way), and one that is 1 where it is engaged (-1: always); pressed:
    parameters that are all > 0 where it is."""

    component: str
    groups: tuple[int, ...]
    factors: tuple[float, ...]
    tie: bool
    switches: tuple[int, ...] = (-1, -1, -1)
    pressed: tuple[int, ...] = ()

    @property
    def row(self) -> RigidRow:
        """Its slip."""
        return RigidRow(self.component, self.groups, self.factors, (), ())


UNKNOWN = -2
_COUNTED = ("states", "parameters", "inputs", "switches", "outputs")
"""What a program says about itself, besides its name."""


class EventTable(NamedTuple):
    """What events say by the number of their switch, the inputs behind the switches: components, the number of each among
    these, its kind ("state" or "time"), and what is shown for modes 0 and 1."""

    components: tuple[str, ...]
    component: NDArray[np.int32]
    timed: NDArray[np.bool_]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Program:
    """C source of one `gb_model` with the meaning of its vectors; lookups by name are made once, when they are asked for.

    n, n_padded, n_total: lengths of the state vector as in c/gb_model.h.
    structural: values of parameters that the structure rests on (ratios); another value needs another program.
    unknown: names of outputs that are NaN: accelerations of shafts without inertia.
    lanes: the laws over lanes in C (solver/lanes.py); "" where the train cannot be stepped so.
    groups, bodies, deflections, slips, algebraic_slips: the train as it turns undeformed, see GroupStart and RigidRow.
    """

    name: str
    source: str
    key: str
    parameters: tuple[ParameterInfo, ...]
    inputs: tuple[InputInfo, ...]
    states: tuple[Quantity, ...]
    switches: tuple[SwitchInfo, ...]
    outputs: OutputList
    energies: tuple[EnergyInfo, ...]
    integrals: tuple[IntegralInfo, ...]
    n: int
    n_padded: int
    n_total: int
    starts: tuple[StartInfo, ...] = ()
    structural: tuple[tuple[str, float], ...] = ()
    dependent_starts: tuple[DependentStart, ...] = ()
    prescribed_starts: tuple[PrescribedStart, ...] = ()
    unknown: tuple[tuple[str], ...] = ()
    lanes: str = ""
    groups: tuple[GroupStart, ...] = ()
    bodies: tuple[RigidRow, ...] = ()
    deflections: tuple[RigidRow, ...] = ()
    slips: tuple[RigidRow, ...] = ()
    heat: tuple[HeatInfo, ...] = ()
    algebraic_slips: tuple[AlgebraicSlip, ...] = ()

    @cached_property
    def output_numbers(self) -> Mapping[str, int]:
        """Numbers of the outputs by name, in their order."""
        return MappingProxyType({name: i for i, name in enumerate(self.outputs.names())})

    @cached_property
    def output_units(self) -> Mapping[str, str]:
        """Units of the outputs by name."""
        return MappingProxyType(dict(zip(self.outputs.names(), self.outputs.units(), strict=True)))

    @cached_property
    def parameter_numbers(self) -> Mapping[str, int]:
        """Numbers of the parameters by path, in their order."""
        return MappingProxyType({p.path: i for i, p in enumerate(self.parameters)})

    @cached_property
    def structural_paths(self) -> frozenset[str]:
        """Paths of the parameters that the structure rests on."""
        return frozenset(path for path, _ in self.structural)

    def why_structural(self, path: str) -> str:
        """What one of them does, in words: one that is 0 takes an inertia away, say."""
        return "is 0" if dict(self.structural)[path] == 0.0 else "enters a ratio"

    @cached_property
    def input_numbers(self) -> Mapping[str, int]:
        """Numbers of the inputs by name."""
        return MappingProxyType({x.name: i for i, x in enumerate(self.inputs)})

    @cached_property
    def input_starts(self) -> NDArray[np.float64]:
        """Values of the inputs before anything is connected."""
        return np.array([x.start for x in self.inputs], dtype=np.float64)

    @cached_property
    def start_numbers(self) -> Mapping[str, int]:
        """Numbers of the start values by name."""
        return MappingProxyType({s.name: i for i, s in enumerate(self.starts)})

    @cached_property
    def event_table(self) -> EventTable:
        """What events say by the number of their switch or input."""
        rows = [(s.component, s.kind == "time", s.low, s.high) for s in self.switches]
        rows += [(x.name, True, 0.0, 1.0) for x in self.inputs]
        number = {name: i for i, name in enumerate(dict.fromkeys(row[0] for row in rows))}
        return EventTable(
            tuple(number),
            np.array([number[row[0]] for row in rows], dtype=np.int32),
            np.array([row[1] for row in rows], dtype=np.bool_),
            np.array([row[2] for row in rows], dtype=np.float64),
            np.array([row[3] for row in rows], dtype=np.float64),
        )

    @cached_property
    def energy_components(self) -> tuple[tuple[str, ...], NDArray[np.intp], NDArray[np.intp]]:
        """Components with stored energies, the number of each energy's among these, and its place in their vector."""
        number = {name: i for i, name in enumerate(dict.fromkeys(e.component for e in self.energies))}
        of = np.array([number[e.component] for e in self.energies], dtype=np.intp)
        return tuple(number), of, np.array([e.offset for e in self.energies], dtype=np.intp)

    @cached_property
    def integral_components(self) -> Mapping[str, tuple[tuple[str, ...], NDArray[np.intp]]]:
        """By "loss" and "supplied": components with such a quadrature and its place in the state vector."""
        found = {}
        for part in ("loss", "supplied"):
            place = {item.component: item.offset for item in self.integrals if item.part == part}
            found[part] = tuple(place), np.array([*place.values()], dtype=np.intp)
        return MappingProxyType(found)

    @cached_property
    def ledger_integrals(self) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
        """Places of all losses and supplies in the state vector, and 1 for a loss, -1 for a supply."""
        (_, loss), (_, supplied) = (self.integral_components[part] for part in ("loss", "supplied"))
        return np.concatenate([loss, supplied]), np.repeat([1.0, -1.0], [len(loss), len(supplied)])

    def __reduce__(self) -> tuple[Any, ...]:
        return Program.from_bytes, (self.to_bytes(),)

    def __repr__(self) -> str:
        lines = self.source.count("\n")
        numbers = ", ".join(f"{len(getattr(self, what))} {what}" for what in _COUNTED)
        return f"Program('{self.name}': {numbers}, {lines} lines of C, key {self.key[:8]})"

    def to_bytes(self) -> bytes:
        """The program as bytes; its tables go column by column and one by one, which takes less time and memory for long
        trains."""
        stream = io.BytesIO()
        for part in fields(self):
            value = getattr(self, part.name)
            if isinstance(value, tuple):
                kind = type(value[0]) if value else None
                pickle.dump(_Table(kind, len(value[0]) if value else 0), stream, protocol=5)
                for i in range(len(value[0]) if value else 0):
                    pickle.dump([row[i] for row in value], stream, protocol=5)
            else:
                pickle.dump(value, stream, protocol=5)
        return stream.getvalue()

    @staticmethod
    def from_bytes(data: bytes) -> Program:
        """The program that `to_bytes` made. Only for bytes that are known to come from there."""
        stream = io.BytesIO(data)
        values: Any = {}
        for part in fields(Program):
            value = pickle.load(stream)
            values[part.name] = value.rows(stream) if isinstance(value, _Table) else value
        return Program(**values)


class _Table(NamedTuple):
    """What stands before the columns of a tuple of equal rows: their class and how many numbers each has."""

    kind: type | None
    width: int

    def rows(self, stream: io.BytesIO) -> tuple[Any, ...]:
        """The rows whose columns follow."""
        if self.kind is None:
            return ()
        rows = zip(*[pickle.load(stream) for _ in range(self.width)], strict=True)
        return tuple(rows) if self.kind is tuple else tuple(map(self.kind._make, rows))  # type: ignore[attr-defined]
