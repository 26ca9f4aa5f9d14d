"""A table that is none is refused with the reason."""

from typing import Any

import pytest

import gearblocks as gb

NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("x", "y", "more", "words"),
    [
        ([0, 1], [0], {}, "same length"),
        ([0], [0], {}, "same length >= 2"),
        ([1, 0], [0, 1], {}, "must increase"),
        ([0, 0], [0, 1], {}, "must increase"),
        ([0, 1], [0, NAN], {}, "finite"),
        ("ab", [0, 1], {}, "x = 'ab' must be a row of numbers"),
        ([0, 1], ["a", "b"], {}, "y = .* must be a row of numbers"),
        ([0, 1], [0, 1j], {}, "y = .* must be a row of numbers"),
        ([0, 1], lambda t: t, {}, "y = .* must be a row of numbers"),
        ([0, 1], [0, 1], {"kind": "qubic"}, "kind = 'qubic'"),
        ([0, 1], [0, 1], {"periodic": True}, "must end where it starts"),
    ],
)
def test_a_table_that_is_none_is_refused(x: Any, y: Any, more: dict[str, Any], words: str) -> None:
    with pytest.raises(gb.GearblocksError, match=f"Table: .*{words}"):
        gb.Table(x, y, **more)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: gb.Table2([0, 1], [0, 1], [[1, float("nan")], [1, 2]]), r"Table2: z\[0\]\[1\] = nan must be a finite number"),
        (lambda: gb.Table2([0, float("inf")], [0, 1], [[1, 2], [1, 2]]), r"Table2: x\[1\] = inf must be a finite number"),
        (lambda: gb.Table2([0, 1, 1], [0, 1], [[1, 2]] * 3), r"Table2: x must increase, but x\[2\] = 1.0 follows 1.0"),
        (lambda: gb.Table2(["0 rpm", "1 rpm"], [0, 1], [[1, 2], [1, 2]]), r"Table2: x = .* points are in SI"),
        (lambda: gb.Table([0, 1], ["1 um", "2 um"]), r"Table: y = .* points are in SI .* convert them before"),
        (lambda: gb.Table("0 1", [1, 2]), r"Table: x = '0 1' must be a row of numbers, not of texts"),
        (lambda: gb.Table([0, None], [1, 2]), r"Table: x = .* must be a row of numbers$|x\[1\] = nan"),
    ],
)  # fmt: skip
def test_points_that_are_none_are_told_by_their_place(make: Any, words: str) -> None:
    with pytest.raises(gb.ParameterError, match=words):
        make()
