"""Modes that went with a compliance, against the frequencies that excite a run.

    A x = s x about the static equilibrium (or the start) of the train with its compliance, its teeth in contact
    near: abs(w/abs(s) - 1) <= 0.2        w: a frequency that excites

A mode belongs to an element that holds a fifth or more of its strain energy. Excitations are those that the blocks declare:
orders of their speeds in the run, and frequencies over time. The modes of a train are looked for once, and kept in the
cache. Knows nothing of how the run was made.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from gearblocks.errors import ParameterError, SimulationError
from gearblocks.language.watches import Excitation
from gearblocks.model.build import build_train, train_digest
from gearblocks.simulation.equilibrium import equilibrium
from gearblocks.solver.cache import digest, user_cache
from gearblocks.solver.fast_modes import fast_modes
from gearblocks.solver.point import Point, opened
from gearblocks.solver.structures import Array
from gearblocks.train.graph import Train

_NEAR = 0.2  # of the natural frequency
_SHARE = 0.2  # of the strain energy
_known: dict[str, dict[str, list[float]]] = {}  # by train and compliances: a few numbers each


class Resonance(NamedTuple):
    """A compliance that was left out, what excites near one of its modes, how often the run came near, when first [s], the
    least and largest frequency [rad/s], and words."""

    effect: str
    of: str
    times: int
    first: float
    low: float
    high: float
    words: str


def resonances(
    full: Train, rigid: Sequence[str], known: Collection[str], t: Array,
    speeds: Callable[[Sequence[str]], Mapping[str, Array]],
) -> list[Resonance]:  # fmt: skip
    """full: the train with the compliances `rigid`; known: outputs of the run; t: times [s] of it, at which `speeds` gives
    outputs by name."""
    exciting = dict.fromkeys((c.path, x) for c in full.components for x in c.block.excitations())
    natural = natural_frequencies(full, rigid) if exciting else {}
    if not any(natural.values()):
        return []
    excited = list(_frequencies(exciting, known, t, speeds))
    found = []
    for effect, rates in natural.items() if excited else ():
        for w in _different(rates):
            rows = [_row(effect, w, of, frequency, t) for of, frequency in excited]
            found += [row for row in rows if row.times] or [min(rows, key=lambda row: _distance(row, w))]
    return found


def _different(rising: Sequence[float]) -> list[float]:
    """One of each group of equal numbers."""
    return [w for i, w in enumerate(rising) if i == 0 or w > rising[i - 1] * (1 + 1e-6)]


def _distance(row: Resonance, w: float) -> float:
    return max(row.low - w, w - row.high, 0.0)


def _row(effect: str, w: float, of: str, frequency: Array, t: Array) -> Resonance:
    near = np.abs(frequency / w - 1) <= _NEAR
    enters = np.flatnonzero(near & ~np.concatenate([[False], near[:-1]]))
    words = f"near its natural frequency of {w / (2 * np.pi):.4g} Hz"
    first = float(t[enters[0]]) if len(enters) else np.nan
    return Resonance(effect, of, len(enters), first, float(frequency.min()), float(frequency.max()), words)


def _frequencies(
    listed: Collection[tuple[str, Excitation]], known: Collection[str], t: Array,
    speeds: Callable[[Sequence[str]], Mapping[str, Array]],
) -> Iterator[tuple[str, Array]]:  # fmt: skip
    """What excites, and its frequency [rad/s] over the times."""
    names = {name for path, x in listed for name in _speed_names(path, x) if name in known}
    found = speeds(sorted(names)) if names else {}
    for path, x in listed:
        if not x.flange:
            yield f"{path}, {x.frequency / (2 * np.pi):.4g} Hz", np.full(len(t), x.frequency)
            continue
        first, *second = _speed_names(path, x)
        if first in found:
            speed = found[first] - (found.get(second[0], 0.0) if second else 0.0)
            yield f"{path}, order {x.order:g}", np.abs(x.order * speed)


def _speed_names(path: str, x: Excitation) -> list[str]:
    return [f"{path}.{flange}.w" for flange in (x.flange, x.against) if flange]


# -- modes ------------------------------------------------------------------------------------------------------------


def natural_frequencies(full: Train, rigid: Sequence[str]) -> dict[str, list[float]]:
    """Natural frequencies [rad/s] of the modes that strain each of these ("shaft.compliance"); none of a long train. From the
    cache, where they were found before."""
    key = digest(train_digest(full), *rigid)
    if key not in _known:
        cache = user_cache()
        stored = cache.read("modes", key)
        _known[key] = _found(full, rigid) if stored is None else json.loads(stored)
        if stored is None:
            cache.write("modes", key, json.dumps(_known[key]).encode())
    return _known[key]


def _found(full: Train, rigid: Sequence[str]) -> dict[str, list[float]]:
    model = build_train(full)
    program = model.program
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        sim.inputs[:] = program.input_starts
        with opened(sim, program, 0.0) as start:
            point = _balanced(start.at(means=True))
            found: dict[str, list[float]] = {name: [] for name in rigid}
            for mode in reversed(fast_modes(point)):
                for name in rigid if mode.swings else ():
                    if sum(share for c, share in mode.shares.items() if _belongs(c, name)) >= _SHARE:
                        found[name].append(mode.rate)
    return found


def _balanced(start: Point) -> Point:
    """The equilibrium, or the start where there is none."""
    try:
        return equilibrium(start)
    except (ParameterError, SimulationError):
        return start


def _belongs(component: str, effect: str) -> bool:
    """Whether a component is the element of an effect, or the part of a composite that it is of: "gear.sun_mesh.compliance"."""
    element = effect.rpartition(".")[0]
    return component == element or component.startswith((f"{element}.", f"{element}["))
