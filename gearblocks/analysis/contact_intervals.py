"""Loss of contact of a mesh, spline, lash or stop: share of time and of revolutions out of contact, impacts.

From the located events of a run and the side of the contact between them, not from samples. Knows nothing of forces.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.quantity import belongs, have
from gearblocks.analysis.sections import Section, section_period
from gearblocks.analysis.span import span_of_run
from gearblocks.errors import ParameterError, UnknownNameError, by_name_only, did_you_mean
from gearblocks.plurals import singular
from gearblocks.simulation.events import KINDS
from gearblocks.simulation.solution import values_at, window_of
from gearblocks.simulation.trajectory import Trajectory

Array = NDArray[np.float64]


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ContactLoss:
    """Loss of contact of `component` between the times after and before [s].

    free: intervals without contact [s], shape (k, 2); closings: times at which contact is made [s], impacts of rigid stops
    among them; time_share: of the time; turn_share: of the revolutions of the angle that was named, or None; per_period:
    closings in a period of the section that was given, or None.
    """

    component: str
    after: float
    before: float
    free: Array
    closings: Array
    turn_share: float | None
    per_period: float | None

    @property
    def time_share(self) -> float:
        """Share of the time without contact."""
        return float(np.diff(self.free, axis=1).sum()) / (self.before - self.after)

    def __repr__(self) -> str:
        turns = "" if self.turn_share is None else f", {100 * self.turn_share:.4g} % of the revolutions"
        each = "" if self.per_period is None else f" ({self.per_period:.4g} in a period)"
        share = f"{100 * self.time_share:.4g} % of the time{turns}"
        return singular(
            f"<'{self.component}' is without contact for {share}; contact is made {len(self.closings)} times{each}>"
        )


@by_name_only
def contact_loss(
    run: Trajectory, component: str, *, angle: str | None = None, section: Section | None = None,
    after: float | str | None = None, before: float | str | None = None,
) -> ContactLoss:  # fmt: skip
    """How long a mesh, spline, lash or stop is out of contact in a run, and how often contact is made.

    angle: an output, such as "pinion.phi", whose revolutions are shared, too; section: gb.stroboscopic("speed"), in whose
    periods closings are counted; after, before: the window [s] (default: the whole run). Raises UnknownNameError where the
    component has no output "contact".

    The answer has time_share, turn_share, per_period, free (the intervals) and closings (the times). In a study its numbers
    are quantities by a function: quantity=lambda run: gb.contact_loss(run, "mesh").time_share.
    """
    start, end = window_of(run, after, before)
    known = set(span_of_run(run).units)
    if f"{component}.contact" not in known:
        having = [name.removesuffix(".contact") for name in known if name.endswith(".contact")]
        raise UnknownNameError(
            f"contact_loss: '{component}' has no output 'contact'; {have(sorted(having), 'nothing here')}"
            f"{did_you_mean(component, having)}"
        )
    if angle is not None and angle not in known:
        raise UnknownNameError(f"contact_loss: there is no output '{angle}'{did_you_mean(angle, known)}")
    if section is not None and not isinstance(section, Section):
        raise ParameterError(f"section = {section!r:.80} must be one, such as gb.stroboscopic('speed')")
    own, blows = _events(run, component, start, end)
    edges = np.unique(np.concatenate([[start], own, [end]]))
    side = values_at(run, run.case, [f"{component}.contact"], 0.5 * (edges[1:] + edges[:-1]))[:, 0]
    off = side == 0.0
    made = edges[1:-1][off[:-1] & ~off[1:] | (side[:-1] * side[1:] < 0)]
    closings = np.unique(np.concatenate([made, blows]))
    shared = None if angle is None else _turns(run, angle, edges, off)
    each = (
        None
        if section is None
        else len(closings) * section_period(section, span_of_run(run).parameters) / (end - start)
    )
    return ContactLoss(component, start, end, _joined(edges, off), closings, shared, each)


def _events(run: Trajectory, component: str, start: float, end: float) -> tuple[Array, Array]:
    """Times of the events of a component within a window, and of its impacts [s]."""
    rows: Any = run.events.array
    mine = np.array([belongs(name, component) for name in run.events.components], dtype=np.bool_)
    rows = rows[mine[rows["component"]]] if len(rows) else rows
    rows = rows[(rows["t"] > start) & (rows["t"] < end)]
    return rows["t"], rows["t"][rows["kind"] == KINDS.index("impact")]


def _turns(run: Trajectory, angle: str, edges: Array, off: NDArray[np.bool_]) -> float:
    turned = np.abs(np.diff(values_at(run, run.case, [angle], edges)[:, 0]))
    if not turned.sum() > 0:
        raise ParameterError(f"contact_loss: '{angle}' does not turn in the window")
    return float(turned[off].sum() / turned.sum())


def _joined(edges: Array, off: NDArray[np.bool_]) -> Array:
    """Intervals without contact; those that follow on each other are one."""
    steps = np.diff(np.concatenate([[False], off, [False]]).astype(np.int8))
    return np.column_stack([edges[np.flatnonzero(steps == 1)], edges[np.flatnonzero(steps == -1)]])
