"""Random calls of FMUs under AddressSanitizer and UBSan: fuzz.c compiled together with the sources of each.

    python tests/fmu/fuzz.py [--calls N] [--seed S] [--long N] [model ...]

Eight models, each with its own share of the calls and a seed of its own. Ends with 0 where no sanitizer reports, no call
takes more than a second of processor time, no damaged state is accepted and no value given is not finite. Needs gcc.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmu_export
import gearblocks as gb

sys.path.insert(0, str(Path(__file__).parents[2] / "models"))
import automatic_gearbox
import dual_clutch
import modelica_examples
import noncircular_cvt
import planetary_backlash
import spline_coupling
import stiff_chain

FLAGS = (
    *("-std=c99", "-O1", "-g", "-ffp-contract=off", "-w"),
    *("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all"),
)
SECONDS = 1.0
"""Of processor time, that no call may take."""
OWN = ("model.c", "fmu_table.c", "fuzz.c")
"""Sources that differ from model to model; the objects of the others are made once."""
SOURCE = Path(__file__).with_name("fuzz.c")


def inertia() -> gb.Drivetrain:
    """One inertia and the torque that is given to it."""
    rig = gb.Drivetrain("one inertia")
    rig.chain(
        rig.add("drive", gb.Torque(tau=gb.Input("tau", start=1.0, unit="N m"))), rig.add("body", gb.Inertia(J=0.5))
    )
    return rig


MODELS: dict[str, Callable[[], Any]] = {
    "inertia": inertia,
    "clutches": modelica_examples.coupled_clutches,
    "spline": spline_coupling.build,
    "cvt": noncircular_cvt.build,
    "gearbox": automatic_gearbox.build,
    "planetary": planetary_backlash.build,
    "chain": stiff_chain.build,
    "dual": dual_clutch.build,
}


@dataclass(frozen=True)
class Answer:
    """What a run of fuzz.c said."""

    good: bool
    words: str


def build(train: Any, folder: Path, objects: Path, **options: Any) -> Path:
    """The program of one train, made in `folder`; `objects` keeps what all trains share."""
    folder.mkdir(parents=True)
    objects.mkdir(exist_ok=True)
    fmu = fmu_export.export(train, folder / "m.fmu", platforms=(), **options)
    with zipfile.ZipFile(fmu) as archive:
        for name in archive.namelist():
            if name.startswith("sources/"):
                (folder / name.removeprefix("sources/")).write_bytes(archive.read(name))
    shutil.copy(SOURCE, folder)
    sources = sorted(path.name for path in folder.glob("*.c"))

    def compiled(name: str) -> Path:
        target = (folder if name in OWN else objects) / f"{name[:-2]}.o"
        if not target.is_file():
            _run(("gcc", *FLAGS, "-c", name, "-o", str(target)), folder)
        return target

    with ThreadPoolExecutor(max_workers=os.cpu_count() or 1) as workers:
        made = [str(path) for path in workers.map(compiled, sources)]
    _run(("gcc", *FLAGS, *made, "-o", "fuzz", "-lm"), folder)
    return folder / "fuzz"


def _run(command: Iterable[str], folder: Path) -> None:
    done = subprocess.run([*command], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr)


def called(program: Path, calls: int, seed: int, long: int, seconds: float = SECONDS) -> Answer:
    """Runs a program. long: one step of so many is longer than a second; 0: none."""
    command = [str(program), str(calls), str(seed), repr(seconds), str(long)]
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    return Answer(done.returncode == 0, done.stdout + done.stderr[-4000:])


def main(names: list[str], calls: int, seed: int, long: int) -> int:
    """Prints what each model said; 0 when all is well."""
    good = True
    with tempfile.TemporaryDirectory(prefix="fuzz-") as place:
        for number, name in enumerate(names or MODELS):
            program = build(MODELS[name](), Path(place) / name, Path(place) / "objects")
            answer = called(program, calls // len(names or MODELS), seed + number, long)
            print(f"-- {name}, seed {seed + number}: {'good' if answer.good else 'BAD'}\n{answer.words}", flush=True)
            good = good and answer.good
    return int(not good)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Random calls of FMUs under sanitizers.")
    parser.add_argument("models", nargs="*", help=f"of {', '.join(MODELS)}; without: all")
    parser.add_argument("--calls", type=int, default=40_000, help="of all models together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--long", type=int, default=400, help="one step of so many is longer than a second")
    given = parser.parse_args()
    sys.exit(main(given.models, given.calls, given.seed, given.long))
