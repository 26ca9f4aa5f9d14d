"""All hard cases: their words from `cases.json`, their judges from the modules beside it."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gearblocks.errors import GearblocksError, UnknownNameError, did_you_mean
from gearblocks.hard import faults, friction, gaps, impacts, size, springs, stepping, ties
from gearblocks.hard.judging import Judge, Meter

JUDGES: Mapping[str, Judge] = {
    "H01": springs.stiffness_ratio,
    "H02": springs.node_of_tiny_inertia,
    "H03": gaps.tiny_gap,
    "H04": gaps.no_gap,
    "H06": impacts.zeno,
    "H07": friction.brake_holds,
    "H08": friction.no_net_torque_while_sliding,
    "H09": friction.no_net_torque_at_rest,
    "H10": friction.equal_speeds,
    "H12": friction.two_locks_at_once,
    "H13": friction.redundant_brakes,
    "H14": friction.braked_ring_and_carrier,
    "H16": friction.long_hold,
    "H17": friction.grazing_capacity,
    "H18": friction.faint_deceleration,
    "H20": springs.inertia_ratio,
    "H21": springs.three_hundred_periods,
    "H23": springs.resonance,
    "H24": springs.mathieu,
    "H25": springs.negative_stiffness,
    "H26": springs.rectangular_stiffness,
    "H28": impacts.contact_at_start,
    "H29": impacts.two_at_once,
    "H31": stepping.a_million_rpm,
    "H32": springs.late_start,
    "H33": springs.micro_units,
    "H34": faults.nan_torque,
    "H35": faults.pole,
    "H36": springs.tolerance_ladder,
    "H37": stepping.lock_up,
    "H39": springs.time_scales,
    "H40": ties.closed_power_loop,
    "H41": ties.contradicting_loop,
    "H42": gaps.chaotic_pair,
    "S43": springs.ten_million_periods,
    "S44": faults.nonsense_values,
    "S45": faults.self_locking_worm,
    "S46": impacts.three_in_a_row,
    "S47": friction.always_zero,
    "S48": stepping.state_across_event,
    "S49": stepping.grids,
    "S51": gaps.order_of_parts,
    "S52": gaps.unit_scaling,
    "S53": ties.prescribed_motion,
    "S54": gaps.time_reversal,
    "S55": friction.events_at_samples,
    "S56": friction.freed_member,
    "S57": friction.slow_belt,
    "S58": size.long_chain,
}


@dataclass(frozen=True, slots=True)
class Attempt:
    """How a solver of scipy fared on the natural script, at rtol 1e-6."""

    ok: bool
    note: str
    seconds: float


@dataclass(frozen=True, slots=True)
class Case:
    """One hard case in words; criterion, naive_failure and scipy are empty where there are none."""

    id: str
    title: str
    model: str
    must_hold: str
    naive_failure: str
    criterion: str
    scipy: Mapping[str, Attempt]

    @property
    def promise(self) -> str:
        """What is checked: the criterion, or where there is none what must hold."""
        return self.criterion or self.must_hold


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a case. seconds: CPU time of all of it, building, compiling and references too; solver_seconds: that
    of the runs alone."""

    case: Case
    passed: bool
    measured: str
    steps: int
    rhs_calls: int
    seconds: float
    solver_seconds: float


def cases(names: Sequence[str] = ()) -> list[Case]:
    """The cases of these names, or all. UnknownNameError for a name that no case has."""
    entries = json.loads(Path(__file__).with_name("cases.json").read_text(encoding="utf-8"))
    found = {entry["id"]: _case(entry) for entry in entries}
    for name in names:
        if name.upper() not in found:
            raise UnknownNameError(
                f"there is no hard case '{name}'; there are {', '.join(found)}{did_you_mean(name.upper(), found)}"
            )
    return [found[name.upper()] for name in names] or list(found.values())


def _case(entry: Mapping[str, Any]) -> Case:
    tried = {name: Attempt(**attempt) for name, attempt in entry.get("scipy", {}).items()}
    words = (entry["id"], entry["title"], entry["model"], entry["must_hold"])
    return Case(*words, entry.get("naive_failure", ""), entry.get("criterion", ""), tried)


def judge(case: Case) -> Outcome:
    """Runs a case. An error of the package that the case does not ask for is a failure."""
    meter, began = Meter(), _cpu()
    try:
        checks = list(JUDGES[case.id](meter))
        passed = all(check.holds for check in checks)
        shown = checks if passed else [check for check in checks if not check.holds]
        measured = "; ".join(dict.fromkeys(check.words for check in shown))
    except GearblocksError as error:
        passed, measured = False, str(error)
    return Outcome(case, passed, measured, meter.steps, meter.rhs_calls, _cpu() - began, meter.seconds)


def _cpu() -> float:
    """CPU time [s] of this process and of the compilers that it called."""
    from os import times

    spent = times()
    return max(time.process_time(), spent.user + spent.system) + spent.children_user + spent.children_system
