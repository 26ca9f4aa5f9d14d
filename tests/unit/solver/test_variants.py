"""Levels of x86-64 that the environment asks for: refused by name, or obeyed with the same bits."""

from __future__ import annotations

import platform

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.errors import CompileError
from gearblocks.solver import variants
from gearblocks.solver.compiler import find_compiler
from gearblocks.solver.library import compiler_here
from gearblocks.solver.variants import VARIABLE, asked_flags

on_x86 = pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="levels of x86-64")


def _rig() -> gb.Drivetrain:
    rig = gb.Drivetrain("swing")
    a, b = rig.add("a", gb.Inertia(J=0.5, w0=1.0)), rig.add("b", gb.Inertia(J=0.3))
    rig.chain(a, rig.add("gap", gb.Lash(k=200.0, c=0.02, half_gap=1e-3)), b)
    return rig


def test_without_the_variable_the_processor_at_hand_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    assert asked_flags(find_compiler()) is None and compiler_here() == find_compiler()


def test_a_name_that_is_none_is_refused_with_those_that_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "x86-64-v33")
    with pytest.raises(CompileError, match=r"x86-64-v33', which is none of x86-64, .* did you mean 'x86-64-v3'"):
        gb.build(_rig())


@on_x86
def test_a_level_that_the_processor_lacks_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "x86-64-v4")
    monkeypatch.setattr(variants, "runs", lambda _: False)
    with pytest.raises(CompileError, match="which this processor does not have"):
        gb.build(_rig())


@on_x86
@pytest.mark.long  # the core is compiled once more
def test_the_plain_level_gives_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    known = gb.simulate(_rig(), t=np.linspace(0, 5, 100))
    monkeypatch.setenv(VARIABLE, "x86-64")
    assert compiler_here().native == ("-march=x86-64",) or compiler_here().is_zig
    found = gb.simulate(_rig(), t=np.linspace(0, 5, 100))
    for name in known.names:
        np.testing.assert_array_equal(found[name], known[name])
