"""Scene: a drivetrain, its drive, a window of time, the quantities asked of it, and how accurately they are wanted.

A frozen value. Knows nothing of how it is run, priced or fitted.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from types import MappingProxyType
from typing import Any, final

from gearblocks.analysis.quantities import SectionPoints
from gearblocks.analysis.quantity import Quantity
from gearblocks.analysis.span import program_span
from gearblocks.analysis.study_point import Measure
from gearblocks.analysis.study_task import measures_of, names_of
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import ParameterError, arguments_told, by_name
from gearblocks.language.expression import finite_number
from gearblocks.language.tidy import Tidy, told
from gearblocks.running import build
from gearblocks.simulation.arguments import Start, begin_of, sample_times


@final
@arguments_told
@told
@dataclass(frozen=True, slots=True, eq=False)
class Scene(metaclass=Tidy):
    """A question to a train: the quantity of a run from t_start to t_end [s], wanted to a share `within` of its value.

        gb.Scene(rig, t_end=0.5, quantity=gb.peak("mesh.force", after=0.2), within=0.01, initial="static")

    drivetrain: the train with all its effects. t_end, t_start: seconds, or text such as "20 ms". quantity: one or several of
    gb.peak, trough, rms, std, mean, at, last, count, event_time, energy_lost, ..., or functions of a trajectory that answer
    a number. within: accuracy wanted, relative to each value. inputs, parameters, initial: as `gb.simulate` takes them.
    name: what it is called (default: the train's name).
    """

    drivetrain: Drivetrain
    _: KW_ONLY
    t_end: float | str
    quantity: Measure | tuple[Measure, ...]
    within: float = 0.01
    t_start: float | str | None = None
    inputs: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, float | str] = field(default_factory=dict)
    initial: Start = None
    name: str = ""

    def __post_init__(self) -> None:
        put = object.__setattr__
        if not isinstance(self.drivetrain, Drivetrain):
            raise ParameterError(f"a scene is of a gb.Drivetrain, not of {self.drivetrain!r:.80}")
        begin = begin_of(self.t_start, self.initial)
        _, end = sample_times(begin, self.t_end, None)
        put(self, "t_start", begin)
        put(self, "t_end", end)
        put(self, "quantity", measures_of(self.quantity, "a scene asks for"))
        for one in self.measures:
            if isinstance(one, SectionPoints):
                raise ParameterError(
                    f"{one.name} is many numbers; a scene asks for one, such as gb.peak('{one.output}')"
                )
        if not 0 < finite_number("within", self.within) < 1:
            raise ParameterError(f"within = {self.within!r} must be a share of the value between 0 and 1, such as 0.01")
        for what in ("inputs", "parameters"):
            put(self, what, MappingProxyType(dict(by_name(what, getattr(self, what)))))
        put(self, "name", str(self.name) or self.drivetrain.name)

    @property
    def measures(self) -> tuple[Measure, ...]:
        """What is asked, as a tuple."""
        assert isinstance(self.quantity, tuple)
        return self.quantity

    @property
    def begin(self) -> float:
        """Where its runs begin [s]."""
        assert isinstance(self.t_start, float)
        return self.t_start

    @property
    def end(self) -> float:
        """Where its runs end [s]."""
        assert isinstance(self.t_end, float)
        return self.t_end

    @property
    def names(self) -> tuple[str, ...]:
        """What is asked, in words: "peak(mesh.force, after=0.2)"."""
        return names_of(self.measures)

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each, "" where it has none or a function tells it."""
        model = build(self.drivetrain)
        span = program_span(model.program, self.begin, self.end, model.values, None)
        found = (m.unit(span) if isinstance(m, Quantity) else "" for m in self.measures)
        return tuple("" if unit == "1" else unit for unit in found)

    def with_units(self, values: Iterable[str]) -> Iterator[str]:
        """Texts of the quantities, in their order, each with its unit."""
        yield from (f"{text} {unit}".rstrip() for text, unit in zip(values, self.units, strict=True))

    def changed(self, **values: Any) -> Scene:
        """The scene with other values, such as another drivetrain, t_end or within."""
        return replace(self, **values)

    def __str__(self) -> str:
        asked = ", ".join(self.names)
        return f"{self.name}: {asked} within {100 * self.within:g} %, from {self.begin:g} to {self.end:g} s"

    def __repr__(self) -> str:
        return f"<Scene {self}>"


def check_scene(function: str, scene: object) -> None:
    """ParameterError where something else than a scene is given to a function."""
    if not isinstance(scene, Scene):
        such = "gb.Scene(train, t_end=0.5, quantity=gb.peak('mesh.force'))"
        raise ParameterError(
            f"{function} takes a gb.Scene, not {scene!r:.80}: ask something of the train, such as {such}"
        )
