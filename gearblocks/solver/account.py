"""What limited the steps of a run (gb_account of c/gb_core.h). Knows nothing of components."""

from __future__ import annotations

import ctypes
from typing import final

import numpy as np

from gearblocks.solver.structures import CAUSES, AccountStructure, address


@final
class Account:
    """Counts of accepted steps and of refused trials, by cause and by the state with the largest error, of n states."""

    def __init__(self, shared: ctypes.CDLL, sim: int | None, n: int) -> None:
        self.accepted_by, self.rejected_by = np.zeros((2, max(n, 1)), dtype=np.int64)
        self._raw = AccountStructure(accepted_by=address(self.accepted_by), rejected_by=address(self.rejected_by))
        shared.gb_keep_account(sim, self._raw)

    @property
    def accepted(self) -> dict[str, int]:
        """Accepted steps by cause."""
        return dict(zip(CAUSES, self._raw.accepted, strict=True))

    @property
    def rejected(self) -> dict[str, int]:
        """Refused trials by cause."""
        return dict(zip(CAUSES, self._raw.rejected, strict=True))
