"""What is possible and yet hardly meant is asked about by rig.describe(), and nothing else is."""

from __future__ import annotations

import math
from typing import Any

import pytest

import gearblocks as gb
from gearblocks.cli import scripts
from gearblocks.language.reference import example_of
from gearblocks.model.plausibility import HIGHEST, implausible

PAIR: dict[str, Any] = {"teeth": (23, 41), "module": 3e-3, "pressure_angle": 0.35, "external": True, "k": 2e8}

pytestmark = pytest.mark.filterwarnings("ignore::gearblocks.errors.GearblocksWarning")  # also told where it is added


def _chain(**blocks: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("rig")
    rig.chain(*(rig.add(name, block) for name, block in blocks.items()))
    return rig


def _pair(**more: Any) -> gb.Drivetrain:
    return _chain(pinion=gb.Inertia(J=0.02), mesh=gb.GearMesh(**(PAIR | more)), wheel=gb.Inertia(J=0.05))


def _between(spring: gb.Block, J: float = 0.02) -> gb.Drivetrain:
    return _chain(left=gb.Inertia(J=J), spring=spring, right=gb.Inertia(J=2.5 * J))


def _doubts(rig: gb.Drivetrain) -> list[str]:
    found = list(implausible(rig.tree()))
    asked = [line for line in rig.describe().splitlines() if line.startswith("is it meant? ")]
    assert asked == [f"is it meant? {words}" for words in found]
    return found


# -- sizes ------------------------------------------------------------------------------------------------------------


def test_a_module_of_millimetres_typed_as_metres_is_asked_about() -> None:
    (words,) = _doubts(_pair(module=3))
    assert (
        words == 'mesh.module = 3 m (normal module) is implausible, more than 0.1 m; 3 mm is written as module="3 mm"'
    )
    assert _doubts(_pair(module=0.1)) == []
    assert _doubts(_pair(module=gb.Parameter("m", 3, "mm"))) == []
    assert len(_doubts(_pair(module=gb.Parameter("m", 3, "m")))) == 1


def test_a_planetary_set_is_asked_once_not_per_planet_and_before_it_is_connected() -> None:
    rig = gb.Drivetrain("rig")
    law = gb.MeshLaw(k=1e8, face_width=20)
    rig.add("gear", gb.PlanetaryGear(z_sun=42, z_planet=18, z_ring=78, module=2, pressure_angle=0.35, planet_inertia=1e-4,
                                     sun_mesh=law))  # fmt: skip
    first, second = _doubts(rig)
    assert first.startswith("gear.module = 2 m (normal module)")
    assert second.startswith("gear.sun_mesh.face_width = 20 m")


def test_a_block_of_a_user_says_what_is_usual() -> None:
    class Wheel(gb.Block):
        """A wheel."""

        hub = gb.Flange("hub")
        r = gb.param("radius", "m", gt=0, usual=2.0)
        T = gb.param("temperature", "K", usual=400)

        def physics(self, s: Any) -> Any:
            yield gb.Body(s.hub, s.r**2)

    assert _doubts(_chain(wheel=Wheel(r=300, T=300), shaft=gb.Shaft(k=1.0), disc=gb.Inertia(J=1.0))) == [
        'wheel.r = 300 m (radius) is implausible, more than 2 m; 300 mm is written as r="300 mm"'
    ]
    (words,) = _doubts(_chain(wheel=Wheel(r=1, T=500), shaft=gb.Shaft(k=1.0), disc=gb.Inertia(J=1.0)))
    assert words == "wheel.T = 500 K (temperature) is implausible, more than 400 K"


# -- parts that are joined to nothing ---------------------------------------------------------------------------------


def test_a_body_that_nothing_is_joined_to_is_asked_about() -> None:
    rig = _pair()
    rig.add("lost", gb.Inertia(J=1.0))
    assert _doubts(rig) == ["'lost' is joined to nothing and moves by itself; connect lost.a or lost.b"]


def test_a_body_inside_a_train_and_a_train_are_asked_about_an_exposed_flange_is_none_to_ask_about() -> None:
    inner = gb.Drivetrain("inner")
    inner.expose("end", inner.add("body", gb.Inertia(J=1.0)).a)
    inner.add("lost", gb.Mass(m=1.0))
    rig = _pair()
    rig.add("stage", inner)
    assert _doubts(rig) == [
        "'stage' is joined to nothing and moves by itself; connect stage.end",
        "'stage.lost' is joined to nothing and moves by itself; connect stage.lost.a or stage.lost.b",
    ]


def test_one_body_alone_is_a_train() -> None:
    rig = gb.Drivetrain("one")
    rig.add("disc", gb.Inertia(J=1.0))
    assert _doubts(rig) == _doubts(gb.Drivetrain("none")) == []


# -- stiffness below zero ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("spring", "words"),
    [
        (
            gb.Shaft(k=1e3 * (1 + 1.2 * gb.cos(30 * gb.time))),
            "spring.k (torsional stiffness) falls to -200 N m/rad at ",
        ),
        (gb.Shaft(k=gb.Table([0.0, 1.0, 2.0], [1.0, -3.0, 1.0])), "falls to -3 N m/rad at 1, below zero"),
        (
            gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.3), external=True, k=1e3 - 2e3 * gb.sin(gb.driver_angle)),
            "spring.k (stiffness about b, also over gb.driver_angle) falls to -1000",
        ),
        (
            gb.Shaft(k=gb.Parameter("P", 2.0) - 3 * gb.Table([0.0, 1.0], [0.0, 1.0])(2 * gb.time)),
            "falls to -1 N m/rad at ",
        ),
    ],
)
@pytest.mark.few(1)
def test_a_stiffness_that_falls_below_zero_within_its_cycle_is_asked_about(spring: gb.Block, words: str) -> None:
    (found,) = _doubts(_between(spring))
    assert words in found
    assert found.endswith("below zero, where it drives its ends apart; let it stay above 0")


@pytest.mark.parametrize(
    "spring",
    [
        gb.Shaft(k=1e3 * (1 + 0.9 * gb.cos(30 * gb.time))),
        gb.Shaft(k=gb.Table([0.0, 1.0, 2.0], [1.0, 0.0, 1.0])),
        gb.Shaft(k=gb.Input("k", 1.0)),
        gb.Shaft(k=2 - gb.sense("left.w")),
        gb.Shaft(torque=gb.Table([-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0])),
        gb.Shaft(k=-3.0, allow_negative=True),
        gb.Shaft(k=1 / gb.time),
    ],
)
def test_a_stiffness_that_stays_above_zero_that_inputs_decide_or_that_was_allowed_is_not(spring: gb.Block) -> None:
    assert _doubts(_between(spring)) == []


# -- natural frequencies ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "spring",
    [
        gb.Shaft(k=3e12),
        gb.Shaft(k=gb.Parameter("k", 3e12)),
        gb.Lash(k=3e12, half_gap=0.0),
        gb.GearMesh(**(PAIR | {"k": 3e15})),
        gb.GearMesh(**(PAIR | {"k": 3e15, "external": False, "helix_angle": 0.2})),
        gb.SplineCoupling(teeth=20, radius=0.03, k=3e15),
    ],
)
@pytest.mark.few(1)
def test_a_mode_above_a_megahertz_is_found_without_computing_modes(spring: gb.Block) -> None:
    rig = _between(spring)
    (words,) = _doubts(rig)
    highest = gb.modes(rig).hertz.max()
    assert highest > HIGHEST
    assert f"gives a natural frequency of {highest / 1e6:.3g} MHz, above 1 MHz" in words
    assert words.startswith("spring.k = 3e+1")
    assert 'rig.without("spring.compliance")' in words


@pytest.mark.long
def test_inertias_behind_ratios_and_the_ground_count_as_they_do_in_the_motion() -> None:
    rig = _chain(
        case=gb.Fixed(), spring=gb.Shaft(k=2e11), disc=gb.Inertia(J=1e-3), gear=gb.IdealGear(ratio=-3.0),
        load=gb.Inertia(J=0.009),
    )  # fmt: skip
    (words,) = _doubts(rig)
    frequency = math.sqrt(2e11 / (1e-3 + 0.009 / 9)) / (2 * math.pi)
    assert f"of {frequency / 1e6:.3g} MHz" in words
    assert gb.modes(rig).hertz.max() == pytest.approx(frequency, rel=1e-9)


@pytest.mark.long
def test_masses_on_springs_count_too() -> None:
    rig = _chain(left=gb.Mass(m=1e-3), spring=gb.Shaft(k=1e12), right=gb.Mass(m=1.0))
    (words,) = _doubts(rig)
    assert f"of {gb.modes(rig).hertz.max() / 1e6:.3g} MHz" in words


def test_the_bound_lies_below_the_highest_mode_of_many_springs() -> None:
    blocks: dict[str, gb.Block] = {"b0": gb.Inertia(J=1e-3)}
    for i in range(1, 5):
        blocks |= {f"s{i}": gb.Shaft(k=i * 3e10), f"b{i}": gb.Inertia(J=i * 1e-3)}
    rig = _chain(**blocks)
    shown = [float(words.partition(" natural frequency of ")[2].split()[0]) for words in _doubts(rig)]
    assert 1.0 <= max(shown) <= gb.modes(rig).hertz.max() / 1e6


@pytest.mark.parametrize(
    "rig",
    [
        _between(gb.Shaft(k=1e8)),
        _chain(
            left=gb.Inertia(J=1.0), spring=gb.Shaft(k=3e13), free=gb.Inertia(J=0.0)
        ),  # nothing moves without inertia
        _chain(left=gb.Inertia(J=1.0), spring=gb.Shaft(rigid=True), right=gb.Inertia(J=1.0)),
    ],
)
def test_slower_and_massless_ends_are_not_asked_about(rig: gb.Drivetrain) -> None:
    assert _doubts(rig) == []


def test_a_train_that_is_not_finished_is_described() -> None:
    rig = gb.Drivetrain("half")
    rig.add("left", gb.Inertia(J=1e-9))
    rig.connect(rig.add("spring", gb.Shaft(k=1e12)).a, rig["left"].b)
    assert _doubts(rig) == []
    assert "spring  Shaft" in rig.describe()


@pytest.mark.parametrize("model", scripts.shipped())
@pytest.mark.few(1)
def test_nothing_is_asked_about_the_trains_and_scenes_of_a_shipped_model(model: str) -> None:
    for maker in scripts.makers(scripts.shipped()[model]):
        made = scripts.made(f"{model}:{maker.name}")
        assert _doubts(made if isinstance(made, gb.Drivetrain) else made.drivetrain) == [], maker.name


@pytest.mark.parametrize(
    "kind", [kind for name in gb.blocks.__all__ if issubclass(kind := getattr(gb, name), gb.Block)]
)
def test_nothing_is_asked_about_the_example_of_a_block(kind: type[gb.Block]) -> None:
    scope: dict[str, Any] = {"gb": gb}
    composed = "\n".join(line for line in example_of(kind).splitlines() if "gb.simulate" not in line)
    exec(composed, scope)  # noqa: S102  our own docstring
    assert _doubts(scope["rig"]) == []
