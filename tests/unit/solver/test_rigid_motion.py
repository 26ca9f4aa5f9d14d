"""Rows over group angles, solved one by one in floating point."""

from __future__ import annotations

import numpy as np
import pytest

from gearblocks.solver.rigid_motion import RigidMotion


def test_rows_agree_with_least_squares_whatever_their_order() -> None:
    rng = np.random.default_rng(7)
    for _ in range(20):
        rows = rng.integers(-3, 4, size=(6, 9)).astype(float)
        wanted = rows @ rng.normal(size=9)
        motion = RigidMotion()
        taken = [motion.take({g: c for g, c in enumerate(row) if c}, d) for row, d in zip(rows, wanted, strict=True)]
        assert sum(taken) == np.linalg.matrix_rank(rows)
        free = [g for g in range(9) if g not in motion.definitions]
        x = np.zeros(9)
        x[free] = rng.normal(size=len(free))
        for g, (factors, constant) in motion.definitions.items():
            assert set(factors) <= set(free)
            x[g] = constant + sum(c * x[other] for other, c in factors.items())
        assert rows @ x == pytest.approx(wanted, abs=1e-11)


def test_a_long_chain_of_equal_speeds_is_exact_and_quick() -> None:
    motion = RigidMotion()
    for i in range(0, 20_000, 2):  # pairs first, then what joins them
        motion.take({i: 1.0, i + 1: -1.0}, 0.0)
    for i in range(1, 19_999, 2):
        motion.take({i: 1.0, i + 1: -1.0}, 0.0)
    assert motion.take({7777: 1.0}, 0.1)
    assert all(motion.value({g: 1.0}) == 0.1 for g in range(0, 20_000, 999))


def test_what_is_determined_is_left_out() -> None:
    motion = RigidMotion()
    assert motion.take({0: 1.0, 1: -0.1}, 0.0) and motion.take({1: 1.0, 2: -0.3}, 0.0)
    assert not motion.take({0: 1.0, 2: -0.03}, 5.0)  # 0.1 times 0.3 is not 0.03 to the last bit
    assert motion.value({0: 1.0}) is None
    assert motion.take({0: 2.0}, 6.0) and motion.value({2: 1.0}) == pytest.approx(100.0, rel=1e-14)


def test_groups_beside_a_constant_are_those_that_something_moves() -> None:
    motion = RigidMotion()
    motion.take({0: 4.0, 1: -1.0, 2: -3.0}, 0.0)
    motion.take({5: 1.0, 6: -1.0}, 0.0)
    assert list(motion.moved()) == []
    motion.take({0: 1.0}, 2.0)
    assert len(list(motion.moved())) == 1
