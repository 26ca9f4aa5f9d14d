"""What cannot act on a quantity, by the graph of the train."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import gearblocks as gb
from gearblocks.analysis.scenes.influence import without_influence


class Governed(gb.Effect):
    """A push that follows a signal."""

    torque: float = gb.signal("torque", "N m")


class Actuator(gb.Block):
    """A user's block whose effect reads another component."""

    flange = gb.Flange("shaft")
    push: Governed | None = gb.effect("push", default=None)

    def physics(self, s: Any) -> Iterator[Any]:
        if self.push is not None:
            yield gb.Acts(s.flange, s.push.torque)
        yield gb.Shows("w", s.flange.w, "rad/s")


def _two(read: bool) -> gb.Drivetrain:
    """Two trains on the ground; the second reads the first where `read`."""
    rig = gb.Drivetrain("two")
    for side in ("left", "right"):
        disc, wall = rig.add(f"{side}_disc", gb.Inertia(J=0.1, phi0=0.1)), rig.add(f"{side}_wall", gb.Fixed())
        rig.chain(disc, rig.add(f"{side}_shaft", gb.Shaft(k=5.0, c=0.1)), wall)
    push = Governed(torque=0.2 * gb.sense("left_disc.w") if read else 0.2)
    rig.connect(rig.add("actuator", Actuator(push=push)).flange, rig["right_disc"].a)
    return rig


def test_what_hangs_on_the_ground_beside_it_has_no_influence() -> None:
    idle = without_influence(_two(read=False).train(), (gb.peak("right_shaft.torque"),))
    assert {"left_shaft", "left_disc"} <= idle and not idle & {"right_shaft", "right_disc", "actuator"}


def test_what_an_effect_of_a_users_block_reads_has_influence() -> None:
    assert "left_shaft" not in without_influence(_two(read=True).train(), (gb.peak("right_shaft.torque"),))
    run = gb.simulate(_two(read=True), t_end=1.0, outputs=["right_shaft.torque"])
    other = gb.simulate(_two(read=True).set({"left_shaft.k": 50.0}), t_end=1.0, outputs=["right_shaft.torque"])
    assert run.extremes("right_shaft.torque") != other.extremes("right_shaft.torque")


def test_one_way_only() -> None:
    assert "right_shaft" in without_influence(_two(read=True).train(), (gb.peak("left_shaft.torque"),))


def test_behind_a_prescribed_speed_nothing_has_influence(discs: Callable[..., gb.Drivetrain]) -> None:
    train = discs().train()
    assert {"belt", "blades"} <= without_influence(train, (gb.peak("shaft.torque"),))
    assert not without_influence(train, (gb.peak("shaft.torque"), gb.peak("belt.torque"))) & {"belt", "blades", "shaft"}


def test_what_turns_with_a_prescribed_shaft_acts_on_the_torque_that_prescribes_it(
    discs: Callable[..., gb.Drivetrain],
) -> None:
    assert not without_influence(discs().train(), (gb.peak("fan.torque"),)) & {"belt", "blades"}


def test_both_sides_of_a_prescribed_shaft_that_is_asked_about() -> None:
    rig = gb.Drivetrain("three")
    rig.add("middle", gb.Speed(w=5.0))
    for side in ("left", "right"):
        rig.connect(rig.add(f"{side}_shaft", gb.Shaft(k=5.0, c=0.1)).a, rig["middle"].flange)
        rig.connect(rig.add(f"{side}_disc", gb.Inertia(J=0.1)).a, rig[f"{side}_shaft"].b)
    assert "left_shaft" in without_influence(rig.train(), (gb.peak("right_disc.w"),))


def test_a_quantity_that_may_read_anything_is_influenced_by_everything(discs: Callable[..., gb.Drivetrain]) -> None:
    for asked in (lambda run: run["shaft.torque"].max(), gb.count(), gb.energy_lost("*")):
        idle = without_influence(discs().train(), (asked,))
        assert not idle & {"belt", "shaft"}, asked
