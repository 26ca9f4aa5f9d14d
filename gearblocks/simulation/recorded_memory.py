"""How much of the machine's memory the record of a run may take."""

from __future__ import annotations

import os
from functools import cache


@cache
def memory_limit(sampled: bool) -> int:
    """Bytes that the record of a run may take: half of the memory (4 GiB where that is not known) with sample times, whose
    number is known, and no more than 2 GiB with every step."""
    try:
        half = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
    except (AttributeError, ValueError, OSError):
        half = 1 << 32
    return half if sampled else min(half, 2 << 30)
