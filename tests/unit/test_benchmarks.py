"""Every benchmark can begin: its module is imported, its C compiles, and the generated C fits the peer by hand."""

import importlib
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
CORE = Path(gb.__file__).parent / "solver" / "c"
needs_cc = pytest.mark.skipif(shutil.which("cc") is None, reason="the peers by hand are compiled with cc")


def test_every_module_is_imported_and_what_is_listed_can_be_run() -> None:
    from benchmarks.__main__ import LONG, NAMES, SHORT, UNOPTIMISED

    for path in sorted(BENCHMARKS.glob("*.py")):
        if not path.name.startswith("__"):
            importlib.import_module(f"benchmarks.{path.stem}")
    assert {*LONG, *SHORT, *UNOPTIMISED} <= {*NAMES}
    assert [
        name for name in NAMES if not callable(getattr(importlib.import_module(f"benchmarks.{name}"), "main", None))
    ] == []


@needs_cc
@pytest.mark.parametrize("kind", [(), ("-DEXTENDED",)], ids=["doubles", "extended"])
def test_the_peers_by_hand_compile(kind: tuple[str, ...]) -> None:
    files = sorted(map(str, (BENCHMARKS / "c").glob("*.c")))
    command = ["cc", "-std=c99", "-fsyntax-only", *kind, "-I", str(CORE), *files]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr


@needs_cc
def test_the_generated_rates_are_called_beside_those_by_hand() -> None:
    """What the core and the generated C give a caller has changed before without the benchmark."""
    from benchmarks.problems import p1
    from benchmarks.rhs import PROBLEM, measured

    model = gb.build(p1(PROBLEM))
    found = measured(model.program.source, model.values, ("-std=c99", "-O0"), 100)
    assert found.shape == (5,) and np.isfinite(found).all()
