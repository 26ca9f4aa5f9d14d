"""Checks of running FMI 2.0 co-simulation instances: token, saved states, reset, several at once, steps of any size."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fmu_export.checks.instance import Instance, Plan, Unpacked
from fmu_export.checks.report import Item

Rows = list[list[float]]


def references(unpacked: Unpacked, *causalities: str) -> list[int]:
    """Value references of the real variables of these causalities."""
    return [v.valueReference for v in reals(unpacked) if v.causality in causalities]


def reals(unpacked: Unpacked) -> Iterator:  # type: ignore[type-arg]
    """All real variables."""
    return (v for v in unpacked.description.modelVariables if v.type == "Real")


def _steps(instance: Instance, refs: list[int], begin: int, end: int, plan: Plan) -> Rows:
    """Outputs after each of the communication steps begin..end."""
    rows = []
    for i in range(begin, end):
        instance.step(plan.begin + i * plan.h, plan.h)
        rows.append(instance.get(refs))
    return rows


def _same(a: Rows, b: Rows) -> bool:
    """Equal bits; what is NaN in both is equal too."""
    return bool(np.array_equal(np.array(a), np.array(b), equal_nan=True))


def check_token(plan: Plan) -> Item:
    """The binary takes the description's token and refuses another."""
    with plan.open():
        pass
    token = plan.unpacked.description.guid
    try:
        with Instance(plan.unpacked, token=token[:-1] + ("0" if token[-1:] != "0" else "1")):
            words = "a wrong guid is accepted"
            return Item("token", False if plan.unpacked.own else None, words)
    except Exception as error:  # noqa: BLE001 - fmpy raises nothing finer
        return Item("token", "instantiate" in str(error), "description and binary agree; a wrong one is refused")


def check_saved_state(plan: Plan) -> Item:
    """Saved, run on, restored, run again: equal bits; also through bytes into another instance."""
    if not plan.unpacked.description.coSimulation.canGetAndSetFMUstate:
        return Item("saved state", None, "not offered")
    refs = references(plan.unpacked, "output")
    data = b""
    with plan.open() as instance:
        instance.start(plan.begin)
        _steps(instance, refs, 0, 10, plan)
        state = instance.fmu.getFMUstate()
        first = _steps(instance, refs, 10, 30, plan)
        instance.fmu.setFMUstate(state)
        same = _same(_steps(instance, refs, 10, 30, plan), first)
        if plan.unpacked.description.coSimulation.canSerializeFMUstate:
            data = instance.fmu.serializeFMUstate(state)
        instance.fmu.freeFMUstate(state)
    if data:
        with plan.open() as other:
            if not plan.unpacked.own:  # one of gearblocks may be as new
                other.start(plan.begin)
            copy = other.fmu.deSerializeFMUstate(data)
            other.fmu.setFMUstate(copy)
            same = same and _same(_steps(other, refs, 10, 30, plan), first)
            other.fmu.freeFMUstate(copy)
    size = len(data)
    words = f"restored runs have equal bits ({size} bytes)" if same else "a restored run differs"
    return Item("saved state", same, words)


def check_reset(plan: Plan) -> Item:
    """A reset instance equals a fresh one, and a second run has the same bits."""
    refs = references(plan.unpacked, "output")
    with plan.open() as fresh:
        fresh.start(plan.begin)
        expected = _steps(fresh, refs, 0, 20, plan)
    with plan.open() as instance:
        instance.start(plan.begin)
        _steps(instance, refs, 0, 7, plan)
        instance.fmu.reset()
        instance.start(plan.begin)
        same = _same(_steps(instance, refs, 0, 20, plan), expected)
    return Item("reset", same, "equals a fresh instance, bit for bit" if same else "differs from a fresh instance")


def check_instances(plan: Plan) -> Item:
    """Two instances that take turns equal one alone."""
    if plan.unpacked.description.coSimulation.canBeInstantiatedOnlyOncePerProcess:
        return Item("instances", None, "one per process only")
    refs = references(plan.unpacked, "output")
    with plan.open() as alone:
        alone.start(plan.begin)
        expected = _steps(alone, refs, 0, 20, plan)
    with plan.open() as a, plan.open() as b:
        a.start(plan.begin)
        b.start(plan.begin)
        rows: tuple[Rows, Rows] = ([], [])
        for i in range(20):
            for instance, row in zip((a, b), rows, strict=True):
                row += _steps(instance, refs, i, i + 1, plan)
    same = all(_same(row, expected) for row in rows)
    return Item("instances", same, "two that take turns equal one alone" if same else "two at once disturb each other")


def check_steps(plan: Plan) -> Item:
    """Many small communication steps lead where one large one does."""
    simulation = plan.unpacked.description.coSimulation
    if not simulation.canHandleVariableCommunicationStepSize:
        return Item("communication step", None, "it takes steps of one size alone")
    refs = references(plan.unpacked, "output")
    with plan.open() as small:
        small.start(plan.begin)
        rows = _steps(small, refs, 0, 64, plan)
    with plan.open() as large:
        large.start(plan.begin)
        large.step(plan.begin, 64 * plan.h)
        last = large.get(refs)
    if _same(rows[-1:], [last]):
        return Item("communication step", True, "64 small steps equal one large step, bit for bit")
    peaks = [max(abs(row[k]) for row in rows) for k in range(len(refs))]
    worst = max((abs(a - b) / p for a, b, p in zip(rows[-1], last, peaks, strict=True) if p > 0), default=0.0)
    words = f"64 small steps differ from one large step by {worst:.1e} of the peak"
    if worst > 1e3 * plan.tolerance and not plan.unpacked.own:
        return Item("communication step", None, words + "; the standard leaves it open")
    return Item("communication step", worst <= 1e3 * plan.tolerance, words)
