"""What a check of an FMU may take: time, memory, size of files."""

from __future__ import annotations

SECONDS_OF_ONE = 200.0
"""Of one check: of a machine that does other things beside it compilers take several times as long."""
SECONDS_OF_ALL = 900.0
"""Of all checks of an FMU together."""
BYTES_OF_MEMORY = 4 << 30
"""Address space of the process that makes the checks, and of each compiler that it starts."""
BYTES_OF_FILES = 2 << 30
"""Of all files in an archive together, and of each file that is written."""
DEATHS = 2
"""Processes that may die or hang before the rest of the checks is left out."""
FILES = 100_000
"""In an archive."""
NAMES = 2_000
"""Variables whose names fmpy parses; it takes milliseconds for each."""


def limit_this_process() -> None:
    """Memory, files and core dumps, where the system has such limits; Windows has none of them."""
    try:
        import resource
    except ImportError:
        return
    for kind, most in (
        (resource.RLIMIT_AS, BYTES_OF_MEMORY),
        (resource.RLIMIT_FSIZE, BYTES_OF_FILES),
        (resource.RLIMIT_CORE, 0),
    ):
        _, hard = resource.getrlimit(kind)
        lower = most if hard == resource.RLIM_INFINITY else min(most, hard)
        try:
            resource.setrlimit(kind, (lower, hard))
        except (OSError, ValueError):  # macOS refuses RLIMIT_AS below what is mapped
            continue
