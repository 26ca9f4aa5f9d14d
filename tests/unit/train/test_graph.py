"""Connections of a train: each that joins nothing, holds nothing or contradicts is named."""

from collections.abc import Callable
from typing import Any

import pytest

import gearblocks as gb


def _inertia(**more: Any) -> gb.Inertia:
    return gb.Inertia(J=1.0, **more)


def _chain(*blocks: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("chain")
    rig.chain(*(rig.add(f"b{i}", block) for i, block in enumerate(blocks)))
    return rig


def _refused(act: Callable[[], Any], *words: str) -> None:
    with pytest.raises(gb.GearblocksError) as caught:
        act()
    for word in words:
        assert word in str(caught.value), str(caught.value)


def test_a_mistaken_flange_is_named_with_the_near_one() -> None:
    rig = gb.Drivetrain("rig")
    mesh = rig.add("mesh", gb.GearMesh(teeth=(1, 2), external=True, module=1e-3, pressure_angle=0.3, k=1.0))
    _refused(lambda: mesh.pinon, "'mesh' (GearMesh) has no flange 'pinon'", "did you mean 'pinion'?")


def test_connections_that_join_nothing_are_refused() -> None:
    rig = gb.Drivetrain("rig")
    a, s = rig.add("a", _inertia()), rig.add("s", gb.Shaft(k=1.0))
    for act, words in (
        (lambda: rig.connect(a.a, a.a), "flange a.a is connected to itself"),
        (lambda: rig.connect(a.a), "at least two"),
        (lambda: rig.connect(), "at least two"),
        (lambda: rig.connect(a, s), "name one of a.{a, b}"),  # type: ignore[arg-type]
        (lambda: rig.connect("a.a", "s.a"), "'a.a' is no flange of 'rig'"),  # type: ignore[arg-type]
        (lambda: gb.Drivetrain("z").connect(a.a, s.a), "is no flange of 'z'"),
        (lambda: rig.chain("a", "s"), "'a' is no part of 'rig'"),  # type: ignore[arg-type]
        (lambda: rig.chain(), "at least two parts"),
        (lambda: rig.chain([a, s]), "at least two parts, one by one"),  # type: ignore[arg-type]
        (lambda: rig.expose("x", "a.a"), "is no flange"),  # type: ignore[arg-type]
        (lambda: rig.expose("a b", a.a), "taken or no word"),
        (lambda: rig.coordinate("t", gb.sense("a.phi"), "rad"), "coordinate name 't' is taken"),
        (lambda: rig.coordinate("x", gb.time, "rad"), "only gb.sense(...)"),
        (lambda: rig.coordinate("x", "a.phi", "rad"), "gb.sense(name)"),
        (lambda: rig["aa"], "has no part 'aa'"),
        (lambda: rig[3], "has no part '3'"),  # type: ignore[index]
    ):
        _refused(act, words)


def test_a_chain_does_not_pass_through_three_flanges() -> None:
    class Three(gb.Block):
        a, b, c = gb.Flange("a"), gb.Flange("b"), gb.Flange("c")

        def physics(self, s: Any) -> Any:
            yield gb.Tie(s.a.phi - s.b.phi)

    _refused(lambda: _chain(_inertia(), Three(), _inertia()), "'b1' has 3 flanges (a, b, c)", "use connect")


def test_a_shaft_on_one_node_and_all_open_ends_are_named_at_once() -> None:
    rig = gb.Drivetrain("rig")
    s, i = rig.add("s", gb.Shaft(k=1.0)), rig.add("i", _inertia())
    rig.connect(s.a, i.a)
    rig.connect(s.b, i.a)
    _refused(lambda: gb.build(rig), "Shaft 's' is connected to itself")
    rig = gb.Drivetrain("rig")
    rig.add("s", gb.Shaft(k=1.0))
    rig.add("g", gb.IdealGear(ratio=2.0))
    rig.add("t", gb.Torque(tau=1.0))
    _refused(lambda: gb.build(rig), "5 problems", "flange 'a' of Shaft 's' is open", "'flange' of Torque 't'")
    _refused(lambda: gb.build(gb.Drivetrain("nothing")), "'nothing' is empty")


def test_a_shaft_without_inertia_that_nothing_holds_is_named_by_its_end() -> None:
    rig = gb.Drivetrain("rig")
    load, brake = rig.add("load", gb.Torque(tau=1.0)), rig.add("other", gb.Torque(tau=1.0))
    rig.connect(load.flange, brake.flange)
    _refused(lambda: gb.build(rig), "the shaft at 'load.flange' has no inertia, and neither spring nor damper holds it")


def test_ties_that_contradict_are_named_with_their_loop() -> None:
    rig = gb.Drivetrain("rig")
    a, b = rig.add("a", _inertia()), rig.add("b", _inertia())
    one, two = rig.add("one", gb.IdealGear(ratio=2.0)), rig.add("two", gb.IdealGear(ratio=3.0))
    rig.connect(a.b, one.a, two.a)
    rig.connect(one.b, two.b, b.a)
    _refused(lambda: gb.build(rig), "'one'", "'two'", "contradict each other", "3 and 2 turns")


class Stage(gb.Block):
    """A composite block of a user's, which bounds nothing itself."""

    a, b = gb.Flange("in"), gb.Flange("out")
    k: float = gb.param("stiffness", "N m/rad")

    def parts(self) -> gb.Parts:
        blocks = {"spring": gb.Shaft(k=self.k, c=0.1), "body": gb.Inertia(J=1.0)}
        return gb.Parts(blocks, ((("spring", "b"), ("body", "a")),), {"a": ("spring", "a"), "b": ("body", "b")})

    def physics(self, s: Any) -> Any:
        return iter(())


def test_numbers_that_a_composite_block_gives_its_parts_are_judged_as_those_of_any_block() -> None:
    _refused(
        lambda: gb.build(_chain(_inertia(), *(Stage(k=k) for k in (1.0, 1.0, -1.0, 1.0)))), "Shaft 'b3.spring': k = -1"
    )
    assert gb.build(_chain(_inertia(), *(Stage(k=1.0) for _ in range(4))))
