"""`python -m benchmarks [--short | --write]`: all benchmarks one after another; --short: with small numbers, to see that each
still runs; --write puts the figures into README.md. Exit status 1 where one fails."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

NAMES = (
    "p1", "p2", "lanes", "p3", "p4", "choice", "locks", "rhs", "assembly", "cold", "studies", "interrupted", "fmu", "watch",
)  # fmt: skip
SHORT = {
    "p1": ("0.002",),
    "lanes": ("20",),
    "p3": ("0.002",),
    "p4": ("--seconds", "0.01", "20"),
    "choice": ("P1",),
    "locks": ("20",),
    "rhs": ("20000",),
    "assembly": ("100",),
    "studies": ("18",),
    "interrupted": ("400",),
    "fmu": ("one inertia",),
}
"""Smaller numbers; what is not named is short as it is."""
UNOPTIMISED = ("fmu",)
"""What the C compiler takes long for; in short form it does not optimise."""
LONG = ("cold", "watch")
"""What has no short form: it compiles the core again and again, or runs in valgrind."""
README = Path(__file__).with_name("README.md")
MARK = "<!-- figures: written by `python -m benchmarks --write` -->"


def output(name: str, short: bool) -> tuple[str, bool]:
    """What one benchmark prints, or the last line of its error, and whether it ran."""
    print(f"running {name} ...", file=sys.stderr, flush=True)
    command = [sys.executable, "-m", f"benchmarks.{name}", *(SHORT.get(name, ()) if short else ())]
    environment = {**({"CC": "cc -O0"} if short and name in UNOPTIMISED else {}), **os.environ}
    run = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    well = run.returncode == 0
    trouble = "" if well else f"\nfailed: {(run.stderr.strip() or 'without a word').splitlines()[-1]}\n"
    return f"## {name}\n\n{run.stdout.strip()}\n{trouble}", well


def main() -> None:
    """Prints everything, or writes it behind the mark in README.md."""
    short = "--short" in sys.argv[1:]
    names = [name for name in NAMES if not (short and name in LONG)]
    found = [output(name, short) for name in names]
    figures = "\n".join(text for text, _ in found)
    if "--write" not in sys.argv[1:]:
        print(figures)
    else:
        head = README.read_text(encoding="utf8").split(MARK)[0]
        README.write_text(f"{head}{MARK}\n\n{figures}", encoding="utf8")
    if not all(well for _, well in found):
        sys.exit(1)


if __name__ == "__main__":
    main()
