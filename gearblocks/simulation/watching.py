"""The watch of one run on effects that were left out of its train, and on tables that it may leave."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import final

import numpy as np

from gearblocks.errors import GearblocksError
from gearblocks.language.watches import Watch
from gearblocks.simulation.resonances import Resonance, resonances
from gearblocks.simulation.samples import Samples
from gearblocks.simulation.watched_effects import Watched, WatchedEffect
from gearblocks.solver.binding import Simulation
from gearblocks.solver.library import Model
from gearblocks.solver.record import Record
from gearblocks.solver.structures import Array
from gearblocks.solver.watches import Seen, Watches


@final
class Watching:
    """The watch of one run: outputs that the core looks at step by step; resonances from some of its rows at the end."""

    def __init__(self, model: Model, sim: Simulation) -> None:
        assert model.left_out is not None
        self._model, self._left = model, model.left_out
        numbers = model.program.output_numbers
        effects = [x for x in self._left.watches() if x[1] in numbers and not _is_zero_limit(x[2])]
        tables = [x for x in self._left.beyond_tables(numbers) if x[1] in numbers]
        self._listed: list[tuple[str, str, Watch]] = [*effects, *tables]
        self._n_effects = len(effects)
        limits = [watch.limit or 0.0 for _, _, watch in self._listed]
        self._watches: Watches | None = None
        if self._listed:
            self._watches = sim.watches([numbers[output] for _, output, _ in self._listed], limits)

    def enter(self, record: Record) -> None:
        """Lets what is recorded here be watched."""
        if self._watches is not None:
            self._watches.enter(record)

    def ended(self, parameters: Array, rows: Sequence[Array]) -> Watched:
        """What the run has shown; its simulation is still where it ended."""
        seen = self._watches.end() if self._watches is not None else []
        told = [_row(*x, s) for x, s in zip(self._listed, seen, strict=True)]
        found, tables = told[: self._n_effects], told[self._n_effects :]
        near = self._resonances(parameters, rows)
        found += [WatchedEffect(x.effect, x.of, x.times, x.first, x.low, x.high, x.words) for x in near]
        shown = {row.effect for row in found}
        return Watched(tuple(found), tuple(name for name in self._left.names if name not in shown), tuple(tables))

    def _resonances(self, parameters: Array, rows: Sequence[Array]) -> Sequence[Resonance]:
        if self._left.full is None or not rows:
            return ()
        program, picked = self._model.program, _some(rows)

        def speeds(names: Sequence[str]) -> Mapping[str, Array]:
            numbers = [program.output_numbers[name] for name in names]
            return dict(zip(names, Samples(self._model.library, parameters, (picked,)).table(numbers).T, strict=True))

        try:
            return resonances(
                self._left.full, self._left.rigid, frozenset(program.output_numbers), picked[:, 0], speeds
            )
        except (GearblocksError, RuntimeError, ArithmeticError):  # nothing is known of the modes of that train
            return ()


_SOME = 512
"""Rows of a run that speeds are looked at."""


def _some(rows: Sequence[Array]) -> Array:
    ends = np.cumsum([len(piece) for piece in rows])
    wanted = np.unique(np.linspace(0, ends[-1] - 1, min(int(ends[-1]), _SOME)).astype(np.intp))
    pieces = np.searchsorted(ends, wanted, side="right")
    return np.array([rows[p][i - (ends[p] - len(rows[p]))] for p, i in zip(pieces, wanted, strict=True)])


def _is_zero_limit(watch: Watch) -> bool:
    return watch.limit is not None and not watch.limit > 0


def _row(effect: str, output: str, watch: Watch, seen: Seen) -> WatchedEffect:
    return WatchedEffect(effect, output, seen.times, seen.first, seen.least, seen.largest, watch.words)
