"""Values of a train: one name means one thing, and all of a change is taken or nothing."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

NAN = float("nan")


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


@pytest.mark.parametrize(
    ("one", "other", "words"),
    [
        (gb.Parameter("P", 1.0), gb.Parameter("P", 2.0), "the name 'P' stands for"),
        (gb.Parameter("P", 1.0, "N m"), gb.Parameter("P", 1.0, "J"), "the name 'P' stands for"),
        (gb.Parameter("P", 1.0), gb.Input("P", 1.0), "the name 'P' stands for"),
        (gb.Input("P", 1.0), gb.Input("P", 2.0), "the name 'P' stands for"),
        (gb.Input("P", 1.0), gb.Input("P", 1.0, "N m"), "the name 'P' stands for"),
        (gb.Parameter("b1.J", 5.0), 1.0, "has the name of the parameter 'b1.J'"),
        (gb.Input("b1.J", 5.0), 1.0, "has the name of the parameter 'b1.J'"),
        (gb.Parameter("b1.w", 5.0), 1.0, "'b1.w' names an input or Parameter and an output"),
        (gb.Input("b1.w", 5.0), 1.0, "'b1.w' names an input or Parameter and an output"),
    ],
)
def test_one_name_means_one_thing(one: Any, other: Any, words: str) -> None:
    _refused(lambda: gb.build(_chain(gb.Torque(tau=one), _inertia(), gb.Torque(tau=other))), words)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"motor.j": 1}, ["'motor.j' does not exist", "did you mean 'motor.J'"]),
        ({"moter.J": 1}, ["'moter.J' does not exist"]),
        ({"J": 1}, ["'J' is not unique", "motor.J", "wheel.J"]),
        ({"motor.J": NAN}, ["Inertia 'motor': J = nan kg m2 must be a finite number"]),
        ({"motor.J": None}, ["a value must be given"]),
        ({"motor.J.x": 3}, ["does not exist"]),
        ({3: 4}, ["path 3 must be text"]),
        ("motor.J", ["must be a dict"]),
        ({"motor": gb.Fixed()}, ["the new 'motor' has no flange 'a', which is connected"]),
        ({"motor": gb.Drivetrain("z")}, ["the new 'motor' has no flange"]),
        ({"motor.J": -1, "shaft.k": -1, "wheel.q": 1}, ["3 problems", "wheel.q", "J = -1", "k = -1"]),
    ],
)
def test_set_names_every_mistake_and_changes_nothing(values: Any, words: list[str]) -> None:
    rig = _rig()
    before = rig.describe()
    _refused(lambda: rig.set(values), *words)
    assert rig.describe() == before


def test_set_takes_values_that_only_fit_together() -> None:
    rig = gb.Drivetrain("rig")
    rig.add("mesh", gb.GearMesh(teeth=(10, 20), external=True, r_base=(0.1, 0.2), k=1.0))
    changed = rig.set({"mesh.teeth": (10, 30), "mesh.r_base": (0.1, 0.3)})
    assert "(10, 30)" in changed.describe()
    _refused(lambda: rig.set({"mesh.teeth": (10, 30)}), "r_base = (0.1, 0.2)", "teeth = (10, 30)")


@pytest.mark.parametrize(("teeth", "external"), [((20, 31), True), ((17, 51), True), ((20, 45), False)])
@pytest.mark.few(1)
def test_a_number_that_follows_from_others_is_no_parameter_of_a_run(teeth: tuple[int, int], external: bool) -> None:
    radii = (0.02, 0.02 * teeth[1] / teeth[0])
    rig = gb.Drivetrain("pair")
    mesh = rig.add("g", gb.GearMesh(teeth=teeth, external=external, k=1e8, r_base=radii))
    drive = rig.add("drive", gb.Torque(tau=1.0))
    rig.chain(drive, rig.add("a", gb.Inertia(J=1.0)), mesh, rig.add("b", gb.Inertia(J=1.0)))
    model = gb.build(rig)
    paths = [p.path for p in model.program.parameters]
    assert "g.r_base[0]" in paths and "g.r_base[1]" not in paths
    with pytest.raises(
        gb.UnknownNameError, match=r"no parameter 'g\.r_base\[1\]'; there are .* - did you mean 'g\.r_base\[0\]'"
    ):
        gb.simulate(model, t_end=0.1, parameters={"g.r_base[1]": 0.05})
    larger = gb.simulate(model, t_end=1e-3, parameters={"g.r_base[0]": 0.04})
    scaled = gb.simulate(rig.set({"g.r_base": (0.04, 2 * radii[1])}), t_end=1e-3)
    assert np.array_equal(larger["a.w"], scaled["a.w"])
