"""The campaign: python -m tests.random --number 3000 --first-seed 1000 [--family mixed] [--workers 2]

One train: --family mixed --seed 17 (its script, all that was found), with --reduce the smallest train that fails alike.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from typing import Any

from tests.random.description import script
from tests.random.families import FAMILIES, draw
from tests.random.pool import judge_all
from tests.random.report import failures, line, table

# of every family some that are judged quickly
SHORT = {
    "smooth": (102, 103, 104, 109), "contact": (100, 102, 104, 105), "friction": (100, 102, 105, 110, 8200043),
    "lossy": (1, 4, 6, 7, 5000142, 6000063), "control": (0, 2, 3, 6, 1800160),
    "mixed": (23, 24, 28, 31, 1400011, 1600257, 4000208),
    "wide": (106, 951000, 951001, 951004, 5000033), "laws": (1, 2, 3),
    "heat": (4, 5, 6000110, 8000057), "warm": (1, 6, 13), "vehicle": (7, 8, 8000010), "feedback": (4, 16),
    "starts": (1, 6, 8000065), "given": (2, 5, 10, 23, 50, 53, 73, 186),
}  # fmt: skip


def main() -> int:
    """Exit status 0 where no train failed."""
    o = _options()
    families = o.family.split(",") if o.family else list(FAMILIES)
    if o.seed is not None:
        return _one(families[0], o.seed, o)
    per_family = -(-o.number // len(families))
    jobs: list[dict[str, Any]]
    if o.short:
        jobs = [{"family": f, "seed": s, "light": True} for f, seeds in SHORT.items() for s in seeds]
    else:
        jobs = [
            {"family": f, "seed": s, "light": o.light}
            for s in range(o.first_seed, o.first_seed + per_family)
            for f in families
        ]
    verdicts: list[dict[str, Any]] = []
    begin = time.monotonic()

    def tell(verdict: dict[str, Any]) -> None:
        verdicts.append(verdict)
        if o.json:
            with open(o.json, "a", encoding="utf-8") as file:
                file.write(json.dumps(verdict) + "\n")
        if failures([verdict]):
            print(line(verdict), flush=True)
        if sys.stderr.isatty():
            print(f"\r{len(verdicts)} of {len(jobs)}, {time.monotonic() - begin:.0f} s ", end="", file=sys.stderr)

    judge_all(jobs, o.workers, o.package, tell)
    print(f"\n{table(verdicts)}\n\n{len(verdicts)} trains in {time.monotonic() - begin:.0f} s")
    failed = failures(verdicts)
    if failed:
        v = failed[0]
        print(f"to repeat one: python -m tests.random --family {v['family']} --seed {v['seed']} [--reduce]")
    return 1 if failed else 0


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.random", description=__doc__)
    parser.add_argument("--number", type=int, default=60, help="trains of all families together")
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--family", help=f"one or several of {', '.join(FAMILIES)}, joined by commas")
    parser.add_argument("--seed", type=int, help="one train alone")
    parser.add_argument("--short", action="store_true", help="the fixed trains of the test suite")
    parser.add_argument(
        "--light", action="store_true", help="two runs against the reference alone, a fifth of the time"
    )
    parser.add_argument("--reduce", action="store_true", help="shrink the train of --seed while it fails alike")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--package", help="another checkout whose gearblocks is judged")
    parser.add_argument("--json", help="a file to which every verdict is appended as a line")
    return parser.parse_args()


def _one(family: str, seed: int, o: argparse.Namespace) -> int:
    train = draw(family, seed)
    found: list[dict[str, Any]] = []
    judge_all([{"family": family, "seed": seed}], 1, o.package, found.append)
    print(script(train))
    _say(found[0])
    if o.reduce and failures(found):
        from tests.random.reduce import reduced

        small, verdict = reduced(train, found[0], o.package)
        print(f"\n# reduced from {len(train.parts)} to {len(small.parts)} parts\n{script(small)}")
        _say(verdict)
    return 1 if failures(found) else 0


def _say(verdict: dict[str, Any]) -> None:
    print(line(verdict, 2000))
    print("evidence:", ", ".join(verdict["evidence"]) or "none", *(f"\n  {note}" for note in verdict["notes"]))


if __name__ == "__main__":
    sys.exit(main())
