"""`python -m benchmarks.assembly [N ...]`: the chain P4 from blocks to compiled, time and peak memory.

Each length in a fresh process with no cached model; the solver core is compiled beforehand, imports are not counted.
Memory is the peak resident size: of the process above what it had at the start, and of the largest child process.
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
from importlib import import_module
from pathlib import Path

from benchmarks.cases import P4
from benchmarks.cold import prepare_core
from benchmarks.fresh import Stopwatch, in_fresh_process, peak_mib


def one(n: int) -> None:
    """Builds and compiles one chain and prints the figures as JSON."""
    import gearblocks as gb
    from models.stiff_chain import chain

    for name in ("jinja2", "sympy"):  # what the first build imports is no part of it
        import_module(name)
    prepare_core()  # every lazy import, too
    before, _ = peak_mib()
    watch = Stopwatch()
    rig = chain(P4(n=n))
    blocks = watch.read()
    model = gb.build(rig)
    built = watch.read()
    own, child = peak_mib()
    figures = {"blocks": blocks, "built": built, "own": own - before, "child": child, "c": len(model.program.source)}
    print(json.dumps(figures))


def main() -> None:
    """Prints one row per length, with the exponent of growth between neighbours."""
    from benchmarks.measure import machine
    from gearblocks.solver.cache import user_cache

    if sys.argv[1:2] == ["--one"]:
        one(int(sys.argv[2]))
        return
    print(machine(), "\n")
    print(
        "| N | blocks s | build s | total s | CPU s | us per inertia | MiB above start | MiB of the compiler | C KiB |"
    )
    print("|--:|--:|--:|--:|--:|--:|--:|--:|--:|")
    for n in [int(a) for a in sys.argv[1:]] or [100, 1000, 10000]:
        with tempfile.TemporaryDirectory() as scratch:
            kept = user_cache().root / "core"
            if kept.is_dir():  # it need not be compiled again
                shutil.copytree(kept, Path(scratch, "core"))
            f = in_fresh_process("benchmarks.assembly", "--one", str(n), cache=Path(scratch))
        blocks, built = f["blocks"], f["built"]
        total, cpu = blocks["wall"] + built["wall"], blocks["cpu"] + built["cpu"]
        cells = [f"{n}", *(f"{x:.3f}" for x in (blocks["wall"], built["wall"], total, cpu)), f"{total / n * 1e6:.0f}"]
        cells += [f"{f['own']:.0f}", f"{f['child']:.0f}", f"{f['c'] / 1024:.0f}"]
        print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
