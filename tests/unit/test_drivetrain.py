"""Composing a train: names of parts, patterns of effects, what is sensed."""

from collections.abc import Callable
from typing import Any

import pytest

import gearblocks as gb


def _inertia(**more: Any) -> gb.Inertia:
    return gb.Inertia(J=1.0, **more)


def _rig() -> gb.Drivetrain:
    rig = gb.Drivetrain("rig")
    rig.chain(
        rig.add("drive", gb.Torque(tau=gb.Input("tau", start=1.0, unit="N m"))),
        rig.add("motor", gb.Inertia(J=0.02)),
        rig.add("shaft", gb.Shaft(k=1.0e3, c=1.0)),
        rig.add("wheel", gb.Inertia(J=0.1)),
    )
    return rig


def _chain(*blocks: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("chain")
    rig.chain(*(rig.add(f"b{i}", block) for i, block in enumerate(blocks)))
    return rig


def _refused(act: Callable[[], Any], *words: str) -> None:
    with pytest.raises(gb.GearblocksError) as caught:
        act()
    for word in words:
        assert word in str(caught.value), str(caught.value)


@pytest.mark.parametrize("name", ["a b", "", 3, None, "1a", "a.b", "a-b", "lump[0]"])
def test_a_part_has_a_plain_name(name: Any) -> None:
    _refused(lambda: gb.Drivetrain("r").add(name, _inertia()), f"part name {name!r} must be a word")


@pytest.mark.parametrize("name", ["", None, 3, " "])
def test_a_drivetrain_has_a_name(name: Any) -> None:
    _refused(lambda: gb.Drivetrain(name), "a Drivetrain needs a name")


@pytest.mark.parametrize(
    ("part", "words"),
    [
        (gb.Inertia, "Inertia is a class: make one with its values"),
        (3, "3 is neither a block nor a Drivetrain"),
        (None, "None is neither"),
        (gb.Backlash(half_gap=1.0), "is an effect, no part: give it to a block"),
    ],
)
def test_only_blocks_and_trains_are_parts(part: Any, words: str) -> None:
    _refused(lambda: gb.Drivetrain("r").add("x", part), words)
    _refused(lambda: _rig().set({"motor": part}), words)


def test_two_parts_of_one_name_are_refused() -> None:
    _refused(lambda: _rig().add("motor", _inertia()), "already has a part named 'motor'")


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("b1.ww", "did you mean 'b1.w'"),
        ("moter.w", "sense('moter.w')"),
        ("b1", "no block shows that output"),
        ("b1.alpha", "cannot be fed back"),
        ("b0.torque", "algebraic loop: b0.torque -> b0.torque"),
    ],
)
def test_a_sense_of_nothing_or_of_itself_is_refused(path: str, words: str) -> None:
    _refused(lambda: gb.build(_chain(gb.Torque(tau=0.5 * gb.sense(path)), _inertia())), words)


@pytest.mark.parametrize("method", ["without", "only"])
def test_patterns_that_match_no_effect_are_named(method: str) -> None:
    take = getattr(_rig(), method)
    _refused(
        lambda: take("*.frction", "shft.compliance"), "2 problems", "'*.frction'", "did you mean 'shaft.compliance'"
    )
    _refused(lambda: take(["shaft.damping"]), "one by one as text")
    _refused(lambda: take(3), "one by one as text")
