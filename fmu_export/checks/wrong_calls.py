"""What an instance answers to calls that an importer must not make, and what it logs.

After an error the standard lets an instance be reset, set to a saved state or freed, and nothing else; so of FMUs of
others every wrong call has an instance of its own, and one that takes it is not blamed: the mistake is the importer's.
Those of gearblocks promise more: an error with a reason, and an instance that goes on.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from fmu_export.checks.instance import OK, Instance, Plan
from fmu_export.checks.lifecycle import references
from fmu_export.checks.report import Item

_NOWHERE = 0x7FFFFFFF
Call = Callable[[Instance], object]


def check_refusals(plan: Plan) -> Item:
    """Wrong calls answer an error and say why."""
    return _own(plan) if plan.unpacked.own else _of_others(plan)


def _before(plan: Plan) -> dict[str, Call]:
    """Wrong before the initialization."""
    return {
        "a step before the initialization": lambda x: x.step(plan.begin, plan.h),
        "an unknown reference": lambda x: x.get([_NOWHERE]),
    }


def _running(plan: Plan) -> dict[str, Call]:
    """Wrong after the first step."""
    outputs, inputs = references(plan.unpacked, "output"), references(plan.unpacked, "input")
    t, h = plan.begin + plan.h, plan.h
    wrong: dict[str, Call] = {
        "a step of zero": lambda x: x.step(t, 0.0),
        "a negative step": lambda x: x.step(t, -h),
        "a step from an earlier time": lambda x: x.step(plan.begin, h),
        "a step of NaN": lambda x: x.step(t, math.nan),
        "setting an unknown reference": lambda x: x.set([_NOWHERE], [0.0]),
        "a second initialization": lambda x: x.fmu.enterInitializationMode(),
    }
    if outputs:
        wrong["setting an output"] = lambda x: x.set(outputs[:1], [0.0])
    if inputs:
        wrong["an input of NaN"] = lambda x: x.set(inputs[:1], [math.nan])
    return wrong


def _run(instance: Instance, plan: Plan) -> None:
    """Up to the end of the first step."""
    instance.start(plan.begin)
    instance.step(plan.begin, plan.h)


def _own(plan: Plan) -> Item:
    """On one instance, which stays usable."""
    before, running = _before(plan), _running(plan)
    outputs = references(plan.unpacked, "output")
    with plan.open() as instance:
        accepted = [name for name, call in before.items() if not instance.refuses(lambda call=call: call(instance))]  # type: ignore[misc]
        _run(instance, plan)
        accepted += [name for name, call in running.items() if not instance.refuses(lambda call=call: call(instance))]  # type: ignore[misc]
        instance.step(plan.begin + plan.h, plan.h)
        bad = not all(math.isfinite(x) for x in instance.get(outputs))
        instance.fmu.terminate()
    found = [f"{name} is accepted or refused without a word" for name in accepted] + ["outputs are not finite"] * bad
    count = len(before) + len(running)
    return Item("refusals", not found, "; ".join(found) or f"{count} wrong calls: an error and a reason for each")


def _of_others(plan: Plan) -> Item:
    """On an instance for each, which is freed after it."""
    taken = []
    for calls, running in ((_before(plan), False), (_running(plan), True)):
        for name, call in calls.items():
            with plan.open() as instance:
                if running:
                    _run(instance, plan)
                if instance.status_of(lambda call=call, instance=instance: call(instance)) == OK:  # type: ignore[misc]
                    taken.append(name)
    count = len(_before(plan)) + len(_running(plan))
    if taken:
        return Item("refusals", None, f"accepted, which the standard leaves open: {'; '.join(taken)}")
    return Item("refusals", True, f"{count} wrong calls: an error for each")


def check_log(plan: Plan) -> Item:
    """Nothing is logged when logging is off; with it on a refusal is."""
    names = [category.name for category in plan.unpacked.description.logCategories]

    def wrong(instance: Instance) -> bool:
        return bool(instance.refuses(lambda: instance.step(plan.begin, -plan.h)))

    with plan.open() as instance:
        instance.start(plan.begin)
        instance.fmu.setDebugLogging(False, [])
        before = len(instance.log)
        if plan.unpacked.own:
            wrong(instance)
        else:
            instance.step(plan.begin, plan.h)
        silent = len(instance.log) == before
    with plan.open() as instance:
        instance.start(plan.begin)
        instance.fmu.setDebugLogging(True, names)
        spoken = wrong(instance)
    found = ["something is logged while off"] * (not silent) + ["a refusal is not logged while on"] * (not spoken)
    sound = not found if plan.unpacked.own or not found else None
    return Item("log", sound, "; ".join(found) or f"{len(names)} categories, silent when off")
