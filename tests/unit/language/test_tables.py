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
