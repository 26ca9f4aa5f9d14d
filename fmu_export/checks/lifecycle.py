"""Checks of a running FMI 2.0 co-simulation instance: start values, refusals, saved states, reset, several at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from fmu_export.checks.instance import Instance, Unpacked
from fmu_export.checks.report import Item

Rows = list[list[float]]


def references(unpacked: Unpacked, *causalities: str) -> list[int]:
    """Value references of the real variables of these causalities."""
    return [v.valueReference for v in _reals(unpacked) if v.causality in causalities]


def _reals(unpacked: Unpacked) -> Iterator:  # type: ignore[type-arg]
    return (v for v in unpacked.description.modelVariables if v.type == "Real")


def _steps(instance: Instance, refs: list[int], begin: int, end: int, h: float) -> Rows:
    """Outputs after each of the communication steps begin..end."""
    rows = []
    for i in range(begin, end):
        instance.step(i * h, h)
        rows.append(instance.get(refs))
    return rows


def check_token(unpacked: Unpacked) -> Item:
    """The binary takes the description's token and refuses another."""
    with Instance(unpacked):
        pass
    wrong = unpacked.description.guid[:-1] + ("0" if unpacked.description.guid[-1] != "0" else "1")
    try:
        with Instance(unpacked, token=wrong):
            return Item("token", False, "a wrong guid is accepted")
    except Exception as error:  # noqa: BLE001 - fmpy raises nothing finer
        return Item("token", "instantiate" in str(error), "description and binary agree; a wrong one is refused")


def check_start_values(unpacked: Unpacked) -> Item:
    """get after instantiate gives the description's start values; what is set comes back."""
    given = [v for v in _reals(unpacked) if v.start is not None]
    refs = [v.valueReference for v in given]
    with Instance(unpacked) as instance:
        values = instance.get(refs)
        wrong = [v.name for v, x in zip(given, values, strict=True) if x != float(v.start)]
        other = [_inside(v, float(v.start)) for v in given]
        instance.set(refs, other)
        lost = [v.name for v, x, y in zip(given, instance.get(refs), other, strict=True) if x != y]
    found = [f"'{name}' differs from the description" for name in wrong] + [f"'{name}' is not kept" for name in lost]
    return Item("start values", not found, "; ".join(found[:5]) or f"{len(given)} as described; set and got back")


def _inside(variable: object, start: float) -> float:
    """Another value within the variable's limits."""
    low = float(getattr(variable, "min", None) or -math.inf)
    high = float(getattr(variable, "max", None) or math.inf)
    candidates = (start * 1.25 + 0.5, start * 0.75, start)
    return next(x for x in candidates if low <= x <= high)


def check_refusals(unpacked: Unpacked, h: float) -> Item:
    """Wrong calls answer an error and say why; the instance stays usable."""
    outputs, inputs = references(unpacked, "output"), references(unpacked, "input")
    with Instance(unpacked) as instance:
        wrong: dict[str, Callable[[], object]] = {
            "a step before the initialization": lambda: instance.step(0.0, h),
            "an unknown reference": lambda: instance.get([0x7FFFFFFF]),
        }
        accepted = [name for name, call in wrong.items() if not instance.refuses(call)]
        instance.start()
        instance.step(0.0, h)
        wrong = {
            "a step of zero": lambda: instance.step(h, 0.0),
            "a negative step": lambda: instance.step(h, -h),
            "a step from an earlier time": lambda: instance.step(0.0, h),
            "a step of NaN": lambda: instance.step(h, math.nan),
            "an unknown reference": lambda: instance.set([0x7FFFFFFF], [0.0]),
            "a second initialization": instance.fmu.enterInitializationMode,
        }
        if outputs:
            wrong["setting an output"] = lambda: instance.set(outputs[:1], [0.0])
        if inputs:
            wrong["an input of NaN"] = lambda: instance.set(inputs[:1], [math.nan])
        accepted += [name for name, call in wrong.items() if not instance.refuses(call)]
        instance.step(h, h)
        bad = not all(math.isfinite(x) for x in instance.get(outputs))
        instance.fmu.terminate()
    found = [f"{name} is accepted or refused without a word" for name in accepted] + ["outputs are not finite"] * bad
    return Item(
        "refusals", not found, "; ".join(found) or f"{len(wrong) + 2} wrong calls: an error and a reason for each"
    )


def check_saved_state(unpacked: Unpacked, h: float) -> Item:
    """Saved, run on, restored, run again: equal bits; also through bytes into another instance."""
    if not unpacked.description.coSimulation.canGetAndSetFMUstate:
        return Item("saved state", None, "not offered")
    refs = references(unpacked, "output")
    with Instance(unpacked) as instance, Instance(unpacked) as other:
        instance.start()
        _steps(instance, refs, 0, 10, h)
        state = instance.fmu.getFMUstate()
        first = _steps(instance, refs, 10, 30, h)
        instance.fmu.setFMUstate(state)
        second = _steps(instance, refs, 10, 30, h)
        same, size = first == second, 0
        if unpacked.description.coSimulation.canSerializeFMUstate:
            data = instance.fmu.serializeFMUstate(state)
            size = len(data)
            copy = other.fmu.deSerializeFMUstate(data)
            other.fmu.setFMUstate(copy)
            same = same and _steps(other, refs, 10, 30, h) == first
            other.fmu.freeFMUstate(copy)
        instance.fmu.freeFMUstate(state)
    words = f"restored runs have equal bits ({size} bytes)" if same else "a restored run differs"
    return Item("saved state", same, words)


def check_reset(unpacked: Unpacked, h: float) -> Item:
    """A reset instance equals a fresh one, and a second run has the same bits."""
    refs = references(unpacked, "output")
    with Instance(unpacked) as fresh:
        fresh.start()
        expected = _steps(fresh, refs, 0, 20, h)
    with Instance(unpacked) as instance:
        instance.start()
        _steps(instance, refs, 0, 7, h)
        instance.fmu.reset()
        instance.start()
        same = _steps(instance, refs, 0, 20, h) == expected
    return Item("reset", same, "equals a fresh instance, bit for bit" if same else "differs from a fresh instance")


def check_instances(unpacked: Unpacked, h: float) -> Item:
    """Two instances that take turns equal one alone."""
    if unpacked.description.coSimulation.canBeInstantiatedOnlyOncePerProcess:
        return Item("instances", None, "one per process only")
    refs = references(unpacked, "output")
    with Instance(unpacked) as alone:
        alone.start()
        expected = _steps(alone, refs, 0, 20, h)
    with Instance(unpacked) as a, Instance(unpacked) as b:
        a.start()
        b.start()
        rows: tuple[Rows, Rows] = ([], [])
        for i in range(20):
            for instance, row in zip((a, b), rows, strict=True):
                row += _steps(instance, refs, i, i + 1, h)
    same = rows == (expected, expected)
    return Item("instances", same, "two that take turns equal one alone" if same else "two at once disturb each other")


def check_steps(unpacked: Unpacked, h: float, tolerance: float) -> Item:
    """Many small communication steps lead where one large one does."""
    refs = references(unpacked, "output")
    with Instance(unpacked) as small, Instance(unpacked) as large:
        small.start()
        large.start()
        rows = _steps(small, refs, 0, 64, h)
        large.step(0.0, 64 * h)
        last = large.get(refs)
    if rows[-1] == last:
        return Item("communication step", True, "64 small steps equal one large step, bit for bit")
    peaks = [max(abs(row[k]) for row in rows) for k in range(len(refs))]
    worst = max((abs(a - b) / p for a, b, p in zip(rows[-1], last, peaks, strict=True) if p > 0), default=0.0)
    words = f"64 small steps differ from one large step by {worst:.1e} of the peak"
    return Item("communication step", worst <= 1e3 * tolerance, words)


def check_log(unpacked: Unpacked, h: float) -> Item:
    """Nothing is logged when logging is off; with it on a refusal is."""
    with Instance(unpacked) as instance:
        instance.start()
        instance.fmu.setDebugLogging(False, [])
        silent = not instance.refuses(lambda: instance.step(0.0, -h)) and not instance.log
        names = [category.name for category in unpacked.description.logCategories]
        instance.fmu.setDebugLogging(True, names)
        spoken = bool(instance.refuses(lambda: instance.step(0.0, -h)))
    found = ["something is logged while off"] * (not silent) + ["a refusal is not logged while on"] * (not spoken)
    return Item("log", not found, "; ".join(found) or f"{len(names)} categories, silent when off")
