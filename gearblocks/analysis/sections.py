"""Stroboscopic points of a driven train. What kind of motion they are of is asked elsewhere (`regimes`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.program import Program
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import ParameterError, by_name_only
from gearblocks.language.signals import Input, Parameter
from gearblocks.language.units import parse_unit
from gearblocks.model.listing import matches
from gearblocks.running import build
from gearblocks.simulation.arguments import parameter_vector, resolve
from gearblocks.simulation.records import NamedValues
from gearblocks.simulation.run import run_model
from gearblocks.solver.library import Model

if TYPE_CHECKING:
    from gearblocks.simulation.trajectory import Trajectory

Array = NDArray[np.float64]

_FINE = 64  # samples of a period
LONGEST = 16  # periods after which a motion is seen to repeat
_LAST = 4  # periods at the end that are sampled finely
RELATIVE = ("deflection", "deflection_rate", "twist", "twist_rate")
"""Outputs that show how parts move against each other."""


@final
@dataclass(frozen=True, slots=True)
class Section:
    """Where points are taken: once per period of the frequency in the parameter `frequency`, from t = 0."""

    frequency: str


@final
@dataclass(frozen=True, slots=True)
class Points:
    """Points of a section. t: times [s], shape (keep,); values: outputs `names`, shape (keep, len(names)).

    extent: largest absolute value of each output during the last periods, between the points too; run: the run that
    they come from, with the last periods in full.
    """

    t: Array
    names: tuple[str, ...]
    values: Array
    extent: Array
    run: Trajectory

    def __repr__(self) -> str:
        listed = ", ".join(self.names[:3]) + (f", ... ({len(self.names)})" if len(self.names) > 3 else "")
        return f"<Points of '{self.run.name}': {len(self.t)} from t = {self.t[0]:g} s: {listed}>"


@by_name_only
def stroboscopic(frequency: str) -> Section:
    """The section once per period of a frequency parameter [rad/s], by its name. Raises ParameterError."""
    if not isinstance(frequency, str):
        name = frequency.name if isinstance(frequency, (Parameter, Input)) else "speed"
        raise ParameterError(
            f"stroboscopic: {frequency!r:.80} must be the name of the Parameter that drives the train, as text, such as "
            f"gb.stroboscopic('{name}')"
        )
    return Section(frequency)


@by_name_only
def poincare(
    train: Drivetrain | Model, section: Section, *, of: Sequence[str] | None = None, transient: int = 300, keep: int = 100,
    rtol: float = 1e-9, parameters: Mapping[str, float | str] | None = None, initial: Mapping[str, float | str] | None = None,
) -> Points:  # fmt: skip
    """Points of a section: `keep` of them after `transient` periods.

    of: patterns of outputs, in the order of the columns (default: all deflections, twists and their rates). rtol, parameters
    and initial: as for `simulate`.
    """
    return section_points(
        build(train), section, of=of, transient=transient, keep=keep, rtol=rtol, parameters=parameters, initial=initial
    )


def section_points(
    model: Model, section: Section, *, of: Sequence[str] | None = None, transient: int = 300, keep: int = 100,
    rtol: float = 1e-9, parameters: Mapping[str, float | str] | None = None, initial: Mapping[str, float | str] | None = None,
) -> Points:  # fmt: skip
    """`keep` points after `transient` periods; of: patterns of outputs, in the order
    of the columns (default: all deflections, twists and their rates)."""
    if transient < 0 or keep < 1:
        raise ParameterError(f"transient = {transient} must be >= 0 and keep = {keep} must be >= 1")
    check_whole(transient=transient, keep=keep)
    vector = parameter_vector(model, parameters or {}, None)
    check_frequency(section, model.program)
    period = section_period(section, NamedValues(model.program.parameter_numbers, vector))
    relative = [q.name for q in model.program.outputs if q.name.rsplit(".", 1)[-1] in RELATIVE]
    patterns = relative if of is None else [of] if isinstance(of, str) else list(of)
    if not patterns:
        raise ParameterError("of = () names no output: the points are those of at least one, such as ['motor.w']")
    t = period * np.arange(transient, transient + keep)
    fine = t[-1] + period * (np.arange(1, _FINE * _LAST) / _FINE - min(_LAST, keep - 1))
    run = run_model(
        model, t=np.union1d(t, fine[(fine > t[0]) & (fine < t[-1])]), rtol=rtol, parameters=parameters, initial=initial,
        outputs=patterns,
    )  # fmt: skip
    names = tuple(dict.fromkeys(name for pattern in patterns for name in run.names if matches(name, pattern)))
    table = np.stack([run[name] for name in names], axis=1)
    extent = np.abs(table).max(axis=0)
    extent[extent == 0.0] = 1.0
    values: Array = table[np.searchsorted(run.t, t)].astype(np.float64)
    return Points(t.astype(np.float64), names, values, extent, run)


def _check_section(section: object) -> None:
    if not isinstance(section, Section):
        raise ParameterError(f"section = {section!r:.80} must be a section such as gb.stroboscopic('speed')")


def check_frequency(section: Section, program: Program) -> None:
    """Raises ParameterError where the parameter of a section measures something else than a frequency; of one that nothing
    is said about it is taken to be in rad/s."""
    _check_section(section)
    names = {p.path: i for i, p in enumerate(program.parameters)}
    told = program.parameters[resolve(section.frequency, names, "parameter")]
    if told.unit not in ("", "1") and not parse_unit(told.unit).measures(parse_unit("rad/s")):
        raise ParameterError(
            f"section: '{section.frequency}' is no frequency, it is in {told.unit}; name a Parameter in rad/s, rpm or Hz that "
            "drives the train"
        )


def section_period(section: Section, parameters: Mapping[str, float]) -> float:
    """Period of a stroboscopic section [s]. Raises ParameterError where its frequency is not above 0."""
    _check_section(section)
    paths = {path: i for i, path in enumerate(parameters)}
    path = [*parameters][resolve(section.frequency, paths, "parameter")]
    frequency = parameters[path]
    if not frequency > 0:
        raise ParameterError(f"the frequency '{section.frequency}' = {frequency!r} rad/s must be > 0")
    return float(2 * np.pi / frequency)


def repeats(points: Array, longest: int, extent: Array) -> tuple[int | None, float, float]:
    """(period, residual, separation); without a period the smallest residual of all that were tried."""
    scaled = points / extent
    best = np.inf
    for m in range(1, longest + 1):
        residual = float(np.abs(scaled[m:] - scaled[:-m]).max())
        best = min(best, residual)
        one = scaled[-m:]
        gaps = [float(np.abs(one[i] - one[j]).max()) for i in range(m) for j in range(i)]
        separation = min(gaps, default=np.inf)
        if residual < 1e-5 and separation > 100 * residual:
            return m, residual, separation
    return None, best, 0.0


def check_whole(**numbers: float) -> None:
    """ParameterError for numbers of periods that are not whole."""
    for name, number in numbers.items():
        if number != int(number):
            raise ParameterError(f"{name} = {number!r} must be a whole number of periods")
