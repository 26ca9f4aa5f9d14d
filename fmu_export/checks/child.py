"""python -m fmu_export.checks.child ORDER: makes the checks of one FMU, one after the other, and writes down each.

A line of JSON says at which check it is, another what came out. ORDER (JSON): the FMU, a folder for its files, the file
to write to, t_end, steps and inputs of the run, and the checks that another process has made before.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fmu_export.checks import file as check_file
from fmu_export.checks import lifecycle, run, start_values, wrong_calls
from fmu_export.checks.inputs import sampled
from fmu_export.checks.instance import Plan, Unpacked, times_of
from fmu_export.checks.limits import limit_this_process
from fmu_export.checks.report import Item
from gearblocks.errors import ParameterError

BEFORE_LOADING = ("archive", "fmpy validation", "description", "binary")
"""The binary is loaded only where none of these has failed."""

BY_INSTANCES: dict[str, Callable[[Plan], Item]] = {
    "token": lifecycle.check_token,
    "start values": start_values.check_start_values,
    "refusals": wrong_calls.check_refusals,
    "saved state": lifecycle.check_saved_state,
    "reset": lifecycle.check_reset,
    "instances": lifecycle.check_instances,
    "communication step": lifecycle.check_steps,
    "log": wrong_calls.check_log,
}


class Child:
    """The checks of one FMU. made: what came out by name of the check, that of earlier processes too."""

    def __init__(self, order: dict[str, Any]) -> None:
        self.fmu, self.folder = Path(order["fmu"]), Path(order["folder"])
        self.t_end, self.steps, self.inputs = order["t_end"], int(order["steps"]), order["inputs"]
        self.said = Path(order["said"])
        self.made = {name: Item(name, ok, words) for name, ok, words in order["made"]}

    def say(self, **line: Any) -> None:
        """One line, whole."""
        with self.said.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(line) + "\n")

    def make(self, name: str, call: Callable[[], Item], differences: dict[str, float] | None = None) -> None:
        """The check `name`, unless it has been made; `differences`: what it may fill in."""
        if name in self.made:
            return
        self.say(at=name)
        try:
            item = call()
        except ParameterError as error:
            item = Item(name, False, str(error))
        except MemoryError:
            item = Item(name, False, "it takes more memory than a check may")
        except Exception as error:  # noqa: BLE001 - a check that breaks down has failed, and says so
            item = Item(name, False, f"{type(error).__name__}: {error}")
        self.made[name] = item
        self.say(item=[item.name, item.ok, item.words[:2000]], differences=differences or {})

    def sound(self, *names: str) -> bool:
        """Whether none of these checks has failed."""
        return all(self.made[name].ok is not False for name in names if name in self.made)

    def check_all(self) -> None:
        """Every check in its order."""
        self.make("archive", lambda: check_file.check_archive(self.fmu))
        if not self.sound("archive"):
            return self.leave_out("description", "the archive is not unpacked")
        self.make("fmpy validation", lambda: check_file.check_validation(self.fmu))
        unpacked = self.unpack()
        if unpacked is None:
            return None
        description = unpacked.description
        self.make("description", lambda: check_file.check_description(description))
        if description.fmiVersion != "2.0" or description.coSimulation is None:
            return self.leave_out("run", "only FMI 2.0 co-simulation is run by this version")
        self.make("binary", lambda: check_file.check_binary(unpacked))
        self.make("sources", lambda: check_file.check_sources(unpacked))
        if not self.sound(*BEFORE_LOADING):
            failed = ", ".join(name for name in BEFORE_LOADING if not self.sound(name))
            return self.leave_out("run", f"the binary is not loaded where a check before it fails ({failed})")
        if description.coSimulation.needsExecutionTool:
            return self.leave_out("run", "it needs the tool that made it")
        return self.load(unpacked)

    def leave_out(self, name: str, words: str) -> None:
        """A check that is not made."""
        self.make(name, lambda: Item(name, None, words))

    def unpack(self) -> Unpacked | None:
        """The FMU in `folder`, or None where fmpy cannot read it: that is the verdict on the description."""
        from fmpy import extract, read_model_description

        if "description" not in self.made:
            self.say(at="description")
        try:
            if not self.folder.is_dir():
                extract(str(self.fmu), str(self.folder))
            return Unpacked(self.folder, read_model_description(str(self.folder), validate=False))
        except Exception as error:  # noqa: BLE001 - what fmpy cannot read is for the report, whatever it raises
            words = f"cannot be read: {error}"
            self.make("description", lambda: Item("description", False, words))
            return None

    def load(self, unpacked: Unpacked) -> None:
        """What needs the binary."""
        begin, stop = times_of(unpacked.description, self.t_end)
        plan = Plan(unpacked, begin, stop, self.steps)
        inputs = sampled(self.inputs, unpacked.description, unpacked.own, plan.points)
        for name, call in BY_INSTANCES.items():
            self.make(name, lambda call=call: call(plan))  # type: ignore[misc]
        results: list[Any] = []
        if "run" not in self.made:
            self.make("run", lambda: run.check_run(plan, inputs, results))
        differences: dict[str, float] = {}
        if results:
            self.make("in-process", lambda: run.compare(plan, inputs, results[0], differences), differences)


def main(order: str) -> None:
    """Limits first, then the checks."""
    limit_this_process()
    child = Child(json.loads(order))
    try:
        child.check_all()
    except ParameterError as error:  # what was asked for makes no sense
        child.say(refused=str(error))
        return
    child.say(done=True)


if __name__ == "__main__":
    main(sys.argv[1])
