"""`python -m benchmarks [--write]`: all benchmarks one after another; --write puts the figures into README.md."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

NAMES = ("p1", "p2", "p3", "p4", "locks", "rhs", "assembly", "cold", "studies")
README = Path(__file__).with_name("README.md")
MARK = "<!-- figures: written by `python -m benchmarks --write` -->"


def output(name: str) -> str:
    """What one benchmark prints, or the last line of its error."""
    print(f"running {name} ...", file=sys.stderr, flush=True)
    run = subprocess.run([sys.executable, "-m", f"benchmarks.{name}"], capture_output=True, text=True, check=False)
    trouble = "" if run.returncode == 0 else f"\nfailed: {run.stderr.strip().splitlines()[-1]}\n"
    return f"## {name}\n\n{run.stdout.strip()}\n{trouble}"


def main() -> None:
    """Prints everything, or writes it behind the mark in README.md."""
    figures = "\n".join(output(name) for name in NAMES)
    if "--write" not in sys.argv[1:]:
        print(figures)
        return
    head = README.read_text(encoding="utf8").split(MARK)[0]
    README.write_text(f"{head}{MARK}\n\n{figures}", encoding="utf8")


if __name__ == "__main__":
    main()
