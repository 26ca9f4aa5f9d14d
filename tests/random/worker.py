"""A child process that judges trains: one line of JSON in, lines of JSON out ("stage" as it goes, then the verdict)."""

from __future__ import annotations

import argparse
import json
import os
import resource
import sys
from typing import Any

MEMORY = 4 << 30  # bytes of address space


def main() -> None:
    """Reads jobs until the input ends."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--package", help="a checkout whose gearblocks is judged")
    options = parser.parse_args()
    if options.package:
        sys.path.insert(0, os.path.abspath(options.package))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    import gearblocks as gb
    from tests.random.families import draw
    from tests.random.judge import Judge, as_dict
    from tests.random.reduce import from_plain

    def say(**values: Any) -> None:
        print(json.dumps(values), flush=True)

    for line in sys.stdin:
        job = json.loads(line)
        say(stage="draw")
        train = from_plain(job["train"]) if "train" in job else draw(job["family"], job["seed"])
        verdict = Judge(gb, train, lambda stage: say(stage=stage)).judge(job.get("light", False))
        say(verdict=as_dict(verdict))


if __name__ == "__main__":
    main()
