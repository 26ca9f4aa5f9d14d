"""Base of the quantities: what one number says about a run. Frozen values that can be named, compared, sent and measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.span import Span, span_of_run
from gearblocks.errors import ParameterError, UnknownNameError, did_you_mean
from gearblocks.language.units import seconds
from gearblocks.model.listing import matches
from gearblocks.simulation.events import KINDS, Events
from gearblocks.simulation.needs import Needs, Solution
from gearblocks.simulation.solution import solution_of
from gearblocks.simulation.trajectory import Trajectory

Array = NDArray[np.float64]

CONTACT = ("contact_made", "contact_lost")
"""Kinds of events beside KINDS: of what has an output "contact" (a mesh, spline, lash or stop)."""


class Quantity:
    """Base of all quantities. `quantity.of(run)` is its value [unit], `quantity.name` the name of its column."""

    __slots__ = ()
    word: ClassVar[str]
    positional: ClassVar[tuple[str, ...]] = ("output",)

    @property
    def name(self) -> str:
        """How it is written: peak(mesh.force, after=0.2)."""
        parts = []
        for item in fields(self):  # type: ignore[arg-type]  # every quantity is a dataclass
            value = getattr(self, item.name)
            if value != item.default:
                shown = f"{value:.12g}" if isinstance(value, float) else str(value)
                parts.append(shown if item.name in self.positional else f"{item.name}={shown}")
        return f"{self.word}({', '.join(parts)})"

    def __str__(self) -> str:
        return self.name

    if not TYPE_CHECKING:  # so that a type checker finds these

        def _no_number(self, *_: object) -> NoReturn:
            raise ParameterError(
                f"{self.name} is asked of a run, no number by itself: what is computed of it is a function, such as "
                f"lambda run: quantity.of(run) / 2"
            )

        __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = __pow__ = _no_number
        __lt__ = __le__ = __gt__ = __ge__ = __neg__ = __abs__ = __float__ = _no_number

    def of(self, run: Trajectory) -> Any:
        """Its value for a run (an array for `points`): on the solution between the samples where the run was made by
        `gb.simulate` in this process, else (a stored run) on splines through its samples."""
        if not isinstance(run, Trajectory):
            raise ParameterError(f"of({run!r:.80}): a quantity is asked of a run, as gb.simulate answers with")
        span = span_of_run(run)
        self.unit(span)
        with solution_of(run, run.case, self.needs(span)) as solution:
            return self.measure(solution, span)

    def unit(self, span: Span) -> str:
        """SI unit; refuses by name what the run does not have. Raises UnknownNameError, ParameterError."""
        raise NotImplementedError

    def needs(self, span: Span) -> Needs:
        """What has to be known of the run."""
        raise NotImplementedError

    def measure(self, run: Solution, span: Span) -> float | Array:
        """The value."""
        raise NotImplementedError

    def length(self, span: Span) -> int | None:  # noqa: ARG002
        """How many numbers it is, None for one."""
        return None

    # -- for the quantities -----------------------------------------------------------------------------------------

    def window(self, span: Span) -> tuple[float, float]:
        """The window [s], checked."""
        after, before = getattr(self, "after", None), getattr(self, "before", None)
        start = span.after if after is None and span.after is not None else span.begin if after is None else after
        end = span.end if before is None else before
        if before is not None and not span.begin < before <= span.end:
            raise ParameterError(
                f"{self.name}: before = {before:g} s must lie within the run, which goes from {span.begin:g} to {span.end:g} s"
            )
        if not span.begin <= start < end:
            raise ParameterError(
                f"{self.name}: after = {start:g} s must lie in the run before {end:g} s; the run goes from {span.begin:g} to "
                f"{span.end:g} s"
            )
        return float(start), float(end)

    def output_unit(self, span: Span) -> str:
        name = getattr(self, "output")  # noqa: B009  declared by those that have one
        if name not in span.units:
            raise UnknownNameError(
                f"{self.name}: there is no output '{name}'{did_you_mean(name, span.units)}; rig.outputs() lists them"
            )
        return span.units[name]

    def chosen(self, events: Events, span: Span) -> NDArray[np.void]:
        """Events of the component and kind that are asked for, within the window."""
        rows, (start, end) = events.array, self.window(span)
        component, kind = getattr(self, "component", None), getattr(self, "kind", None)
        keep = (rows["t"] >= start) & (rows["t"] <= end)
        if component is not None:
            wanted = np.array([belongs(name, component) for name in events.components], dtype=np.bool_)
            keep &= wanted[rows["component"]]
        if kind in KINDS:
            keep &= rows["kind"] == KINDS.index(kind)
        elif kind is not None:
            touching = np.array([_touches(name, span) for name in events.components], dtype=np.bool_)
            keep &= touching[rows["component"]] & _contact(rows, made=kind == CONTACT[0])
        chosen: NDArray[np.void] = rows[keep]
        return chosen

    def check_events(self, span: Span) -> None:
        component, kind = getattr(self, "component", None), getattr(self, "kind", None)
        kinds = (*KINDS, *CONTACT)
        if kind is not None and kind not in kinds:
            raise ParameterError(
                f"{self.name}: kind = {kind!r} must be one of {', '.join(kinds)}{did_you_mean(kind, kinds)}"
            )
        known(self.name, component, span.components, "events")
        if kind in CONTACT:
            having = tuple(name.removesuffix(".contact") for name in span.units if name.endswith(".contact"))
            known(self.name, component or "*", having, "contact")


def _touches(component: str, span: Span) -> bool:
    """Whether its events are those of a contact: a mesh, spline or lash itself, each side of a stop."""
    owner, _, part = component.rpartition(".")
    return f"{component}.contact" in span.units or (part in ("lower", "upper") and f"{owner}.contact" in span.units)


def _contact(rows: NDArray[np.void], made: bool) -> NDArray[np.bool_]:
    """Events that make contact (from none, from the other side, or by an impact), or lose it."""
    before, after, state = rows["before"], rows["after"], rows["kind"] == KINDS.index("state")
    if not made:
        return np.asarray(state & (before != 0) & (after == 0))
    found = (state & (after != 0) & (before != after)) | (rows["kind"] == KINDS.index("impact"))
    return np.asarray(found)


def time_of(name: str, value: float | str | None) -> float | None:
    """A time that may be given, in s or as text with its unit."""
    return None if value is None else seconds(name, value)


def text_of(what: str, value: Any) -> str:
    """The name that is asked for. Raises ParameterError."""
    if not isinstance(value, str):
        raise ParameterError(f"{what} = {value!r:.80} must be the name of one, such as 'mesh.force'")
    return value


def belongs(name: str, component: str) -> bool:
    """Whether a component is the one that is asked for, a part of it, or matches the pattern."""
    return name == component or name.startswith(f"{component}.") or matches(name, component)


def have(names: Sequence[str], none: str) -> str:
    """Who has what was asked for, as the end of a sentence."""
    return f"{', '.join(names) or none} {'have' if len(names) > 1 else 'has'}"


def known(quantity: str, component: str | None, names: tuple[str, ...] | None, what: str) -> None:
    if component is not None and names is not None and not any(belongs(name, component) for name in names):
        raise UnknownNameError(
            f"{quantity}: '{component}' has no {what}; {have(names, 'nothing in this train')}"
            f"{did_you_mean(component, names)}"
        )
