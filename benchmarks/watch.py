"""`python -m benchmarks.watch [SCENE ...]`: what a run takes more that watches an effect which was left out, counted in
instructions by valgrind's callgrind; Linux on x86-64 alone.

Each effect of a shipped scene whose absence an output shows is left out by itself, alike ones once, and the train is run
with the watch and without.
"""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import gearblocks as gb
from gearblocks.cli import scripts

SHARES = {
    "gear_pair:rattle": 0.1, "gear_pair:whine": 0.1, "two_speed_shift:shift": 0.002, "planetary_backlash:settled": 0.1,
    "spline_coupling:period_5": 0.1, "spline_coupling:chaos": 0.1,
}  # fmt: skip
"""Scenes of which an effect can be watched, and how much of each window is run: under callgrind all takes 50 times as long."""
LIMIT = 2.0
"""Percent, where a gap is left out of scenes whose steps are not cheap."""
LIMITED = ("gear_pair:rattle", "gear_pair:whine", "two_speed_shift:shift")
MARKS = Path(__file__).parent / "c" / "counting.c"
VARIANT = "x86-64-v3"
"""Valgrind knows no AVX-512."""


class Case(NamedTuple):
    """A scene, an effect that is left out of it, and how far it is run [s]."""

    scene: str
    effect: str
    end: float


def cases(names: list[str]) -> Iterator[Case]:
    """The effects of these scenes whose absence is watched; of alike ones (names that differ in numbers) the first."""
    for name in names:
        scene, seen = scripts.scene(name), set[str]()
        for effect in scene.drivetrain.effects():
            lean, alike = scene.drivetrain.without(effect), re.sub(r"\d+", "*", effect)
            known, left = {output.name for output in lean.outputs()}, lean.left_out()
            assert left is not None
            if alike not in seen and any(output in known for _, output, _ in left.watches()):
                seen.add(alike)
                yield Case(name, effect, scene.begin + SHARES[name] * (scene.end - scene.begin))


def run(each: list[Case], marks: ctypes.CDLL) -> None:
    """Under callgrind: every case without the watch and with it, a dump behind each. Nothing is counted before all is built."""
    warnings.simplefilter("ignore", gb.GearblocksWarning)
    ready = []
    for case in each:
        scene = scripts.scene(case.scene)
        model = gb.build(scene.drivetrain.without(case.effect))
        initial = gb.carried_start(scene.drivetrain, model, initial=scene.initial)
        gb.simulate(model, t_end=scene.begin + 0.01 * (case.end - scene.begin), initial=initial, outputs=())
        ready.append((model, initial, case.end))
    marks.begin_counting()
    for model, initial, end in ready:
        for watch in (False, True):
            done = gb.simulate(model, t_end=end, initial=initial, watch=watch, outputs=())
            marks.counted(f"{done.stats.steps} {done.stats.events}".encode())


def counted(dump: str, function: str) -> int:
    """Instructions of a function with all that it calls, in a dump of callgrind; names stand where they are met first."""
    names, callee, found = dict[str, str](), "", 0
    lines = iter(dump.splitlines())
    for line in lines:
        if named := re.match(r"c?fn=\((\d+)\)(?: (.*))?$", line):
            names[named[1]] = named[2] or names[named[1]]
            if line.startswith("cfn"):
                callee = names[named[1]]
        elif line.startswith("calls=") and re.fullmatch(rf"{function}('\d+)?", callee):
            found += int(next(lines).split()[1])
    return found


def measured(each: list[Case], folder: Path) -> Iterator[tuple[Case, int, int, int, int]]:
    """Each case with its steps, its events, and the instructions of all C that is called: without the watch, and what it
    adds."""
    os.environ["GEARBLOCKS_VARIANT"] = VARIANT
    for case in each:  # in valgrind it would take minutes
        gb.build(scripts.scene(case.scene).drivetrain.without(case.effect))
        gb.build(scripts.scene(case.scene).drivetrain)
    library = folder / "counting.so"
    subprocess.run(["cc", "-O1", "-shared", "-fPIC", str(MARKS), "-o", str(library)], check=True)
    command = [
        "valgrind", "--tool=callgrind", "--instr-atstart=no", f"--callgrind-out-file={folder / 'dump'}",
        sys.executable, "-m", "benchmarks.watch", "--under", str(library),
    ]  # fmt: skip
    words = [word for case in each for word in (case.scene, case.effect, repr(case.end))]
    told = subprocess.run([*command, *words], capture_output=True, text=True, check=False)
    if told.returncode:
        sys.exit(told.stderr)
    for i, case in enumerate(each):
        bare, watched = ((folder / f"dump.{2 * i + k}").read_text(encoding="utf8") for k in (1, 2))
        steps = re.search(r"Client Request: (\d+) (\d+)", watched)
        assert steps is not None
        without = counted(bare, "ffi_call")
        yield case, int(steps[1]), int(steps[2]), without, counted(watched, "ffi_call") - without


def main(names: list[str]) -> None:
    """Prints the table; exit status 1 where the watch takes more than its limit."""
    if shutil.which("valgrind") is None:
        print("valgrind is not here")
        return
    print(
        "| scene | without | steps | events | instructions a step | watch a step | watch |\n|---|---|--:|--:|--:|--:|--:|"
    )
    worst = 0.0
    with tempfile.TemporaryDirectory() as folder:
        for case, steps, events, bare, more in measured(list(cases(names)), Path(folder)):
            share = 100 * more / bare
            shown = f"| {case.scene} | {case.effect} | {steps} | {events} | {bare / steps:,.0f} | {more / steps:,.0f} "
            print(f"{shown}| {share:.2f} % |", flush=True)
            if case.scene in LIMITED and case.effect.endswith("backlash"):
                worst = max(worst, share)
    if worst > LIMIT:
        sys.exit(1)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--under"]:
        words = sys.argv[3:]
        each = [Case(a, b, float(c)) for a, b, c in zip(words[::3], words[1::3], words[2::3], strict=True)]
        run(each, ctypes.CDLL(sys.argv[2]))
    else:
        main(sys.argv[1:] or list(SHARES))
