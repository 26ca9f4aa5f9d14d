"""What a run keeps of its samples: times, states, modes and inputs; outputs are evaluated from these when they are asked for.

A row is [t | y | modes | inputs] (c/gb_core.h, gb_record).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from gearblocks.plurals import singular
from gearblocks.solver.library import Library
from gearblocks.solver.structures import Array

AT_ONCE = 32 << 20
"""Bytes up to which all outputs of a run are evaluated when the first one is read; beyond, those that are asked for."""
_BATCH = 4096  # rows whose outputs are evaluated in one call


@final
@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Recorded rows of one run, in pieces, with the parameters that hold for all of them."""

    library: Library
    parameters: Array
    pieces: tuple[Array, ...]

    def __len__(self) -> int:
        return sum(len(piece) for piece in self.pieces)

    def times(self) -> Array:
        """Times of the samples [s], in one row that cannot be written to."""
        if len(self.pieces) == 1:
            found = self.pieces[0][:, 0].copy()
        else:
            found = np.concatenate([piece[:, 0] for piece in self.pieces]) if self.pieces else np.empty(0)
        found.flags.writeable = False
        return found

    def batches(self, pick: Sequence[int], *, energies: bool = False) -> Iterator[tuple[Array, Array]]:
        """Outputs by their numbers, shape (rows, picks), and energies, shape (rows, energies or 0), batch by batch."""
        chosen = np.array(pick, dtype=np.intc)
        with self.library.open() as sim:
            sim.parameters[:] = self.parameters
            for piece in self.pieces:
                for start in range(0, len(piece), _BATCH):
                    _, out, energy = sim.evaluate(piece[start : start + _BATCH], chosen, energies=energies)
                    yield out, energy

    def table(self, pick: Sequence[int]) -> Array:
        """Outputs by their numbers, shape (len(self), picks)."""
        found, row = np.empty((len(self), len(pick))), 0
        for out, _ in self.batches(pick):
            found[row : row + len(out)] = out
            row += len(out)
        return found

    def largest_energy(self) -> float:
        """The greatest sum of all stored energies at a sample [J]; -inf without samples."""
        largest = -np.inf
        with np.errstate(invalid="ignore", over="ignore"):  # a run that blows up
            for _, energy in self.batches((), energies=True):
                largest = max(largest, float(energy.sum(axis=1).max(initial=-np.inf)))
        return largest


@final
class Outputs(Mapping[str, Array]):
    """Outputs of a run by name, each evaluated when it is first read, or all of them at once where they are small."""

    __slots__ = ("_known", "_numbers", "_samples")

    def __init__(self, samples: Samples, numbers: Mapping[str, int]) -> None:
        self._samples, self._numbers = samples, numbers
        self._known: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        if name not in self._known:
            if name not in self._numbers:
                raise KeyError(name)
            all_of_them = 8 * len(self._samples) * len(self._numbers) <= AT_ONCE
            self.read([*self._numbers] if all_of_them else [name])
        return self._known[name]

    def read(self, names: Sequence[str]) -> None:
        """Evaluates those of the named outputs that are not known yet, all in one pass."""
        missing = [name for name in names if name not in self._known]
        if missing:
            table = self._samples.table([self._numbers[name] for name in missing])
            table.flags.writeable = False
            self._known.update((name, table[:, j]) for j, name in enumerate(missing))

    def __contains__(self, name: object) -> bool:
        return name in self._numbers

    def __iter__(self) -> Iterator[str]:
        return iter(self._numbers)

    def __len__(self) -> int:
        return len(self._numbers)

    def only(self, names: Sequence[str]) -> Outputs:
        """The named ones; what is known already is not evaluated again."""
        chosen = Outputs(self._samples, {name: self._numbers[name] for name in names})
        chosen._known.update((name, self._known[name]) for name in names if name in self._known)
        return chosen

    def batches(self) -> Iterator[Array]:
        """All of them, shape (rows, outputs), batch by batch; nothing is kept."""
        return (out for out, _ in self._samples.batches([*self._numbers.values()]))

    def __repr__(self) -> str:
        return singular(f"<{len(self)} outputs at {len(self._samples)} samples, {len(self._known)} evaluated>")

    def __reduce__(self) -> tuple[Any, ...]:
        return Outputs, (self._samples, dict(self._numbers))
