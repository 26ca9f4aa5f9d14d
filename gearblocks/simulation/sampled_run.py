"""A stored run between its samples: splines of degree 5 through the samples of each smooth piece, from event to event.

As good as its samples lie close. Knows nothing of models and solvers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import ParameterError
from gearblocks.simulation.events import Events
from gearblocks.simulation.extrema import NODES, WEIGHTS, extremum
from gearblocks.simulation.needs import Along
from gearblocks.simulation.records import EnergyLedger

Array = NDArray[np.float64]


class Run(Protocol):
    """What is read of a run (see `Trajectory`)."""

    t: Array

    @property
    def events(self) -> Events: ...
    @property
    def energy(self) -> EnergyLedger: ...
    @property
    def meta(self) -> Mapping[str, Any]: ...
    def __getitem__(self, name: str) -> Array: ...


@final
class SampledRun:
    """A run with its values between the samples, of which nothing but the samples is known; times: edges of segments too."""

    def __init__(self, run: Run, times: Sequence[float] = ()) -> None:
        if len(run.t) < 2:
            raise ParameterError("a quantity needs a run of at least two samples")
        self._run = run
        edges = np.flatnonzero(np.diff(run.t) <= 0) + 1
        self._pieces = [(int(a), int(b)) for a, b in zip([0, *edges], [*edges, len(run.t)], strict=True) if b - a > 1]
        split = np.array(times, dtype=np.float64)
        self._edges = [
            np.union1d(run.t[a:b], split[(split > run.t[a]) & (split < run.t[b - 1])]) for a, b in self._pieces
        ]
        self.t0: Array = np.concatenate([edges[:-1] for edges in self._edges])
        self.t1: Array = np.concatenate([edges[1:] for edges in self._edges])

    @property
    def events(self) -> Events:
        """Those of the run."""
        return self._run.events

    def lost(self, component: str, time: float) -> float:
        """Energy lost up to the begin or the end of the run [J]; what it was between is not stored."""
        if time <= self._run.t[0]:
            return 0.0
        if time < self._run.t[-1]:
            raise ParameterError("a stored run knows its losses from begin to end only: leave out after and before")
        return float(self._run.energy.dissipated[component])

    def along_run(self, wanted: Along) -> float:
        """What an output is along the run."""
        t0, t1, nodes = self._within(wanted.output, wanted.after, wanted.before)
        if wanted.factor:
            nodes = nodes * self._within(wanted.factor, wanted.after, wanted.before)[2]
        h = t1 - t0
        if wanted.kind in ("peak", "trough"):
            sign = 1.0 if wanted.kind == "peak" else -1.0

            def sample(times: Array) -> Array:
                other = self._sample(wanted.factor, times) if wanted.factor else 1.0
                return sign * self._sample(wanted.output, times) * other

            return sign * extremum(t0, t1, sign * nodes, sample, float(self._run.meta.get("rtol", 1e-6)))
        if wanted.kind == "mean":
            return float((h * (nodes * WEIGHTS).sum(axis=1)).sum() / h.sum())
        if wanted.kind == "std":
            nodes = nodes - (h * (nodes * WEIGHTS).sum(axis=1)).sum() / h.sum()
        scale = float(np.abs(nodes).max(initial=0.0)) or 1.0  # so that no square leaves the range of doubles
        return scale * float(np.sqrt((h * ((nodes / scale) ** 2 * WEIGHTS).sum(axis=1)).sum() / h.sum()))

    def static_value(self, output: str) -> float:
        """Refused: a stored run does not hold its train."""
        raise ParameterError(
            f"a stored run does not know '{output}' in its static equilibrium: run it again with gb.simulate"
        )

    def _splines(self, output: str) -> list[Callable[[Array], Array]]:
        from scipy.interpolate import make_interp_spline

        t, values = self._run.t, self._run[output]
        return [make_interp_spline(t[a:b], values[a:b], k=_degree(b - a)) for a, b in self._pieces]

    def value(self, output: str, time: float) -> float:
        """The output at a time, the right limit at an event."""
        return float(self._sample(output, np.array([time]))[0])

    def table(self, outputs: Sequence[str], times: Array) -> Array:
        """Outputs at times, shape (times, outputs)."""
        return np.column_stack([self._sample(output, times) for output in outputs])

    def _sample(self, output: str, times: Array) -> Array:
        """The output at times [s]."""
        starts = np.array([self._run.t[a] for a, _ in self._pieces])
        piece = np.maximum(np.searchsorted(starts, times, side="right") - 1, 0)
        found, splines = np.empty(len(times)), self._splines(output)
        for i in np.unique(piece).tolist():
            found[piece == i] = splines[i](times[piece == i])
        exact = np.searchsorted(self._run.t, times, side="right") - 1
        hit = self._run.t[exact] == times
        found[hit] = self._run[output][exact[hit]]
        return found

    def _within(self, output: str, after: float, before: float) -> tuple[Array, Array, Array]:
        """Segments within a window: t0, t1, shape (S,), and the output at their nodes, shape (S, 5)."""
        rows = []
        for spline, edges in zip(self._splines(output), self._edges, strict=True):
            at = edges[:-1, None] + np.diff(edges)[:, None] * NODES
            rows.append(np.asarray(spline(at.ravel())).reshape(at.shape))
        part = (self.t0 >= after) & (self.t1 <= before)
        return self.t0[part], self.t1[part], np.concatenate(rows)[part]


def _degree(samples: int) -> int:
    """An odd degree that so many samples can carry."""
    return 5 if samples > 5 else 3 if samples > 3 else 1
