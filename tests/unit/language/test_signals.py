"""Parameters and inputs: finite numbers under plain names."""

from typing import Any

import numpy as np
import pytest

import gearblocks as gb

NAN, INF = float("nan"), float("inf")
P, U = gb.Parameter("P", 2.0), gb.Input("u", 3.0)


@pytest.mark.parametrize("value", [NAN, INF, "3", True, [1], None, 1j, gb.time, P, np.array([1.0, 2.0])])
def test_parameters_and_inputs_hold_finite_numbers(value: Any) -> None:
    for make in (gb.Parameter, gb.Input):
        with pytest.raises(gb.ParameterError, match=f"{make.__name__} 'p': (value|start) = "):
            make("p", value)


@pytest.mark.parametrize("name", ["", "a b", "1a", ".", "a..b", 3, None, "a-b"])
def test_parameters_and_inputs_have_plain_names(name: Any) -> None:
    for make in (gb.Parameter, gb.Input):
        with pytest.raises(gb.ParameterError, match=r"name .* must be words"):
            make(name, 1.0)
        with pytest.raises(gb.ParameterError, match="unit = 3 must be text"):
            make("p", 1.0, 3)
