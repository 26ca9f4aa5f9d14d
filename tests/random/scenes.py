"""Random scenes: what `gb.price` and `gb.fit` say of them, against direct runs.

    python -m tests.random.scenes --number 3 --first-seed 100

Every row, verdict, counter and sentence is held against `gb.simulate` of trains made with `without`, at a tight tolerance, or
as means over runs whose inertias differ by 1e-7 where these scatter. Knows nothing of how the package judges.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import gearblocks as gb
from tests.random.scene_draw import scene

Array = NDArray[np.float64]
TIGHT, MANY = 1e-9, 24


class Direct(NamedTuple):
    """Quantities by direct runs and what they are uncertain by, shape (quantities,); scattered: means over runs."""

    values: Array
    noise: Array
    scattered: bool
    runs: Array | None = None


class Failed(NamedTuple):
    """A run that there is not, or a quantity that is not in it."""

    lost: bool


def values(s: gb.Scene, rig: gb.Drivetrain, share: float = 1.0, stretch: int = 1, **how: Any) -> tuple[Array, Any]:
    """Quantities and counters of one run; share: of the inertia of the first body."""
    first = next(p for p in rig.parameters() if p.name.endswith(".J"))
    parameters = {first.name: share * first.value, **s.parameters} if share != 1.0 else s.parameters
    initial = gb.carried_start(s.drivetrain, rig, initial=s.initial, parameters=s.parameters)
    run = gb.simulate(
        rig, t_end=stretch * s.end, initial=initial, parameters=parameters, watch=False, **({"rtol": TIGHT} | how)
    )
    return np.array([m.of(run) for m in s.measures if isinstance(m, gb.Quantity)]), run.stats


def direct(s: gb.Scene, rig: gb.Drivetrain, stretch: int = 1) -> Direct | Failed:
    """The quantities of a train, by one run and another, or by many where these differ."""
    try:
        one, other = values(s, rig, stretch=stretch)[0], values(s, rig, 1 + 1e-8, stretch, rtol=1e-7)[0]
        if np.all(np.abs(one - other) <= 1e-2 * s.within * np.abs(one)):
            return Direct(one, np.abs(one - other), False)
        shares = [
            1 + sign * 1e-7 * n for n in range(1, MANY // 2 + 1) for sign in (1, -1)
        ]  # what is only sensitive: no drift
        runs = np.array([values(s, rig, share, stretch, rtol=1e-8)[0] for share in shares])
        return Direct(runs.mean(axis=0), 3 * runs.std(axis=0, ddof=1) / MANY**0.5, True, runs)
    except gb.UnknownNameError:
        return Failed(True)
    except (gb.SimulationError, gb.ModelError, gb.ParameterError):
        return Failed(False)


def change(full: Direct, lean: Direct) -> tuple[Array, Array]:
    """Relative changes, and what they are uncertain by."""
    size = np.abs(full.values)
    found = (lean.values - full.values) / size
    return found, (lean.noise + full.noise * (1 + np.abs(found))) / size + 1e-9


def alone_off(s: gb.Scene, full: Direct, lean: Direct, which: int) -> bool:
    """Whether single runs are off by more than the accuracy, where only the motion without the effects scatters."""
    if full.scattered or lean.runs is None:
        return False
    off = np.abs(lean.runs[:, which] / full.values[which] - 1)
    return bool(off.max() > s.within)


def complaints(seed: int) -> Iterator[str]:
    """What is not as direct runs say of the scene of a seed."""
    s = scene(seed)
    yield from complaints_of(s, gb.fit(s), _driven)


def complaints_of(s: gb.Scene, best: Any, there: Callable[[gb.Scene, str, float], gb.Scene]) -> Iterator[str]:
    """What is not as direct runs say; there: the scene at a share of its "load" or "speed"."""
    price = best.price
    full = direct(s, s.drivetrain)
    assert isinstance(full, Direct)
    off = np.abs(price.full.values - full.values) > price.full.errors + full.noise + 1e-9 * np.abs(full.values)
    if off.any():
        yield f"with everything {price.full.values} +- {price.full.errors}, directly {full.values} +- {full.noise}"
    for row in price.rows:
        yield from (f"{row.name}: {words}" for words in _row(s, row, full))
    yield from _told(price)
    yield from _fitted(s, best, full, there)
    if best.trains > 40:
        yield f"{best.trains} trains were built"
    every = set().union(*(row.effects for row in price.rows)) | set(price.untried)
    if not price.untried and every != set(s.drivetrain.effects()):
        yield f"nothing is said of {sorted(set(s.drivetrain.effects()) - every)}"


def _row(s: gb.Scene, row: Any, full: Direct) -> Iterator[str]:
    lean_rig = s.drivetrain.without(*row.effects)
    found, verdict = row.judgement, str(row.judgement.verdict)
    if found.stretch > 1:
        longer = direct(s, s.drivetrain, found.stretch)
        assert isinstance(longer, Direct)
        full = longer
    lean = direct(s, lean_rig, found.stretch)
    if isinstance(lean, Failed):
        if verdict != ("takes the quantity along" if lean.lost else "does not run"):
            yield f"said {verdict}, but it {'goes along' if lean.lost else 'does not run'}"
        return
    changes, noise = change(full, lean)
    if verdict == "cannot influence it":
        if (np.abs(changes) > noise + 1e-6).any():
            yield f"without influence, but {changes}"
        return
    if verdict in ("takes the quantity along", "does not run"):
        yield f"said {verdict}: {row.message}; directly {changes}"
        return
    if (np.abs(changes - found.changes) > found.errors + noise).any():
        yield f"changes {found.changes} +- {found.errors}, directly {changes} +- {noise}"
    for i, (one, c, n) in enumerate(zip(found.verdicts, changes, noise, strict=True)):
        if (one == "needed" and abs(c) + n < s.within and not alone_off(s, full, lean, i)) or (
            one == "not needed" and abs(c) - n > s.within
        ):
            yield f"said {one}, directly {c:.3g} +- {n:.2g} of {s.within}"
    n = len(gb.build(s.drivetrain).program.states) - len(gb.build(lean_rig).program.states)
    run, said = values(s, lean_rig, rtol=1e-6)[1], row.stats
    if row.states != n or (said.steps, said.rhs_calls, said.events) != (run.steps, run.rhs_calls, run.events):
        yield f"{row.states} states fewer, {said}; directly {n}, {run}"


HEADS = {
    "needed": "needed", "undecided": "undecided", "not needed by itself": "not needed",
    "without influence": "cannot influence it",
    "part of the quantity": "takes the quantity along", "not to be taken away": "does not run",
}  # fmt: skip


def _told(price: Any) -> Iterator[str]:
    """The sentence of a price, part by part, against its rows."""
    said: set[str] = set()
    for part in re.sub(r"^.*? within [0-9.]+ %: ", "", price.sentence).split("; "):
        head, _, names = part.partition(": ")
        verdict = HEADS.get(head, head.removeprefix("together "))
        for name in re.sub(r" \((?:[^()]|\([^()]*\))*\)", "", names).split(", "):
            if head == "not tried":
                continue
            said |= price[name].effects
            if str(price[name].judgement.verdict) != verdict:
                yield f"the sentence calls {name} {verdict}, its row {price[name].judgement.verdict}"
    missing = {e for row in price.rows for e in row.effects} - said
    if missing:
        yield f"the sentence does not speak of {sorted(missing)}: {price.sentence}"


def _fitted(s: gb.Scene, best: Any, full: Direct, there: Callable[[gb.Scene, str, float], gb.Scene]) -> Iterator[str]:
    """The fitted train: what went, the run as it is told to be made, and the scenes around."""
    if set(best.drivetrain.effects()) != set(s.drivetrain.effects()) - set(best.dropped):
        yield f"fit: {best.dropped} said to go, left are {best.drivetrain.effects().keys()}"
    lean = direct(s, best.drivetrain)
    if isinstance(lean, Failed):
        yield "fit: the fitted train does not run"
        return
    changes, noise = change(full, lean)
    if (np.abs(changes) - noise > s.within).any():
        yield f"fit: {best.dropped} may go, directly {changes} +- {noise}"
    if not lean.scattered:
        run = values(s, best.drivetrain, method=best.method, rtol=best.rtol, step=best.step, locate=best.locate)[0]
        if (np.abs(run - full.values) > s.within * np.abs(full.values) + full.noise).any():
            yield f"fit: run with {best.effort} it is {run}, not {full.values} within {s.within}"
    for one in (*best.around, *best.spoilt):
        what, share = one.words.split()[0], 1 + float(one.words.split()[1]) / 100
        trial = best.trial if best.around else best.given_up
        found = _beside(there(s, what, share), one, trial.effects)
        yield from (f"fit, {one.words}: {words}" for words in found)


def _driven(s: gb.Scene, what: str, share: float) -> gb.Scene:
    """A random scene at a share of its Parameter `load` or `speed`, and of what goes with it."""
    given = {p.name: float(p.value) for p in s.drivetrain.parameters() if isinstance(p.value, (int, float))}
    initial = s.initial
    parameters = {what: share * given[what]} if what in given else {}
    if what == "load":
        parameters |= {name: share * value for name, value in given.items() if name.startswith("pump.coeffs")}
    if what == "speed" and isinstance(initial, dict):
        initial = {name: share * float(w or 0.0) for name, w in initial.items()}
    return s.changed(parameters=parameters, initial=initial)


def _beside(there: gb.Scene, one: Any, effects: frozenset[str]) -> Iterator[str]:
    full, lean = direct(there, there.drivetrain), direct(there, there.drivetrain.without(*effects))
    if isinstance(full, Failed) or isinstance(lean, Failed):
        if not one.message:
            yield "judged, but a run of it fails"
        return
    changes, noise = change(full, lean)
    if (np.abs(changes - one.judgement.changes) > one.judgement.errors + noise + 1e-9).any():
        yield f"changes {one.judgement.changes} +- {one.judgement.errors}, directly {changes} +- {noise}"
    if one.holds and (np.abs(changes) - noise > there.within).any():
        yield f"said to hold, directly {changes} +- {noise}"
    single = any(alone_off(there, full, lean, i) for i in range(len(changes)))
    if one.judgement.verdict == "needed" and (np.abs(changes) + noise < there.within).all() and not single:
        yield f"said not to hold, directly {changes} +- {noise}"


def main() -> int:
    """Exit status 0 where all is as direct runs say."""
    parser = argparse.ArgumentParser(prog="python -m tests.random.scenes", description=__doc__)
    parser.add_argument("--number", type=int, default=3)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--show", action="store_true", help="print what is said of each scene")
    o = parser.parse_args()
    failed = 0
    for seed in range(o.first_seed, o.first_seed + o.number):
        begin = time.process_time()
        if o.show:
            print(gb.fit(scene(seed)).price)
        found = list(complaints(seed))
        failed += bool(found)
        print(
            f"scene {seed}: {'as direct runs say' if not found else ''} ({time.process_time() - begin:.0f} s CPU)",
            flush=True,
        )
        for words in found:
            print(f"    {words}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
