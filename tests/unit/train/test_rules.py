"""Rules of blocks: every value that a block refuses when it is built is refused when a run gives it, and as a Parameter."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.language.reference import example_of
from gearblocks.language.signals import Value
from gearblocks.model.build import program_of
from gearblocks.simulation.arguments import parameter_vector
from gearblocks.solver.library import Model
from gearblocks.train.graph import Component
from gearblocks.train.rules import Rules
from gearblocks.train.values import numbers_of, replaced, value_problems

TRIED = (-1e9, -50.0, -1.05, -1.0, 0.0, 0.5, 1.05, 1.6, 3.0, 1e3, 1e9)
TEETH: dict[str, Any] = {"teeth": (20, 30), "external": True}
MODULE: dict[str, Any] = {**TEETH, "module": 2e-3, "pressure_angle": 0.35}
SPLINE: dict[str, Any] = {"teeth": 20, "radius": 0.02, "k": 1e8, "c": 100.0}
BLOCKS = [getattr(gb.blocks, name) for name in gb.blocks.__all__]
HEATED = gb.HeatPort(T=300.0)
TYRE = gb.TyreSlip(stiffness=1e5, grip=1.0, low_speed=0.5)
COUPLINGS = {
    "gap with two ends": gb.Lash(k=100.0, c=1.0, lower=-0.1, upper=0.1),
    "waves": gb.SplineCoupling(**SPLINE, stiffness_variation=gb.Fourier(cos=(0.5, 0.1), sin=(0.1,))),
    "square": gb.SplineCoupling(
        **SPLINE, stiffness_variation=gb.Square(ripple=0.3, contact_ratio=1.6, driven_by=100.0)
    ),
    "smooth gap": gb.GearMesh(**MODULE, k=1e8, c=1.0, backlash=gb.Backlash(half_gap=1e-5, law="smooth", width=1e-6)),
    "polynomial": gb.GearMesh(**MODULE, k=1e8, backlash=gb.Backlash(half_gap=1e-5, law="polynomial", degree=3)),
    "standard": gb.GearMesh(
        **MODULE, stiffness="iso6336", face_width=0.02, profile_shift=(0.1, 0.1), damping_ratio=0.05,
        friction=gb.ToothFriction(mu=0.05),
    ),
    "impacts": gb.GearMesh(
        **TEETH, r_base=(0.02, 0.03), k=1e8, contact_damping=gb.HuntCrossley(restitution=0.5),
        backlash=gb.Backlash(half_gap=1e-5),
    ),
    "losses": gb.LossyGear(ratio=2, efficiency=(0.9, 0.8), bearing=(0.1, 0.1)),
    "gearbox": gb.Gearbox(ratio=2, efficiency=(0.9, 0.8), bearing=(0.1, 0.1), k=1e4, half_gap=1e-3, c=1.0),
    "disc clutch": gb.Clutch(mu=0.3, force_max=100.0, engagement=1.0, geometry=0.1, peak=1.1),
    "stops": gb.HardStop(lower=-0.1, upper=0.2, restitution=0.5),
    "hysteresis": gb.Shaft(k=100.0, hysteresis=gb.Hysteresis(friction=1.0, stiffness=10.0)),
    "segments": gb.Shaft(k=100.0, J=1.0, segments=3, c=0.1),
    "ellipse": gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.3), external=True, k=1e4, c=1.0),
    "belt": gb.BeltDrive(ratio=2, slip=gb.Creep(stiffness=1e3, low_speed=0.1, limit=100.0)),
    "joint": gb.UniversalJoint(angle=0.2, phase=0.1),
}  # fmt: skip
ENDS = {
    "bearing": gb.BearingFriction(coulomb=1.0, viscous=0.1, peak=1.2, stribeck=gb.Stribeck(rise=0.1, speed=1.0)),
    "windage": gb.BearingFriction(windage=gb.FluidDrag(c=1.0)),
    "eddies": gb.EddyCurrentBrake(
        tau_nominal=1.0, w_nominal=10.0, excitation=0.5, alpha=0.004, T_ref=290.0, heat=HEATED
    ),
    "car": gb.Vehicle(
        mass=1200.0, wheel_radius=0.3, drag_area=0.6, rolling=0.01, rolling_speed=0.1, grade=0.02, wind=1.0, tyre=TYRE
    ),
}


def _chain(*blocks: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("chain")
    rig.chain(*(rig.add(f"b{i}", block) for i, block in enumerate(blocks)))
    return rig


def _between(block: gb.Block) -> gb.Drivetrain:
    return _chain(gb.Torque(tau=1.0), gb.Inertia(J=1.0), block, gb.Inertia(J=1.0))


def _example(kind: Any) -> gb.Drivetrain:
    scope: dict[str, Any] = {"gb": gb}
    exec("\n".join(line for line in example_of(kind).splitlines() if "gb.simulate" not in line), scope)  # noqa: S102
    rig: gb.Drivetrain = scope["rig"]
    return rig


def _at_the_end(block: gb.Block) -> gb.Drivetrain:
    return _chain(gb.Torque(tau=1.0), gb.Inertia(J=1.0), block)


TRAINS: dict[str, Callable[[], gb.Drivetrain]] = {
    **{name: partial(_between, block) for name, block in COUPLINGS.items()},
    **{name: partial(_at_the_end, block) for name, block in ENDS.items()},
    **{kind.__name__: partial(_example, kind) for kind in BLOCKS if issubclass(kind, gb.Block)},
}


def model_of(rig: gb.Drivetrain) -> Model:
    """The model without its library, which nothing here runs."""
    train = rig.train()
    program, values = program_of(train)
    start = np.array([values.get(p.path, 0.0) for p in program.parameters])
    library: Any = None
    return Model(program, library, start, rules=Rules(train.components))


def _said(model: Model, values: dict[str, float]) -> str:
    try:
        parameter_vector(model, values, None)
    except gb.ParameterError as error:
        return str(error)
    return ""


def _tried(c: Component, model: Model) -> Iterator[tuple[str, float, str]]:
    """(path inside the block, value, what is said of it at build) of its numbers."""
    for path, value, spec in numbers_of(c.block, ""):
        full = f"{c.path}.{path}"
        if type(value) is not float or spec.role not in ("param", "signal") or spec.leading:
            continue
        if full in model.program.parameter_numbers and full not in model.program.structural_paths:
            for x in TRIED:
                yield path, x, "; ".join(value_problems(c.path, replaced(c.block, path.split("."), x)))


@pytest.mark.parametrize("name", TRAINS)
@pytest.mark.few(10)
def test_what_a_block_refuses_is_refused_of_a_run_and_of_a_parameter(name: str) -> None:
    rig = TRAINS[name]()
    model = model_of(rig)
    for c in rig.train().components:
        for path, x, at_build in _tried(c, model):
            in_run = _said(model, {f"{c.path}.{path}": x})
            assert bool(at_build) == bool(in_run), (c.path, path, x, at_build, in_run)
            if not c.slides:  # the unit is told where it is known
                assert in_run.removeprefix(f"{c.path}.") in at_build, (at_build, in_run)
            named = replaced(c.block, path.split("."), gb.Parameter("P", x))
            assert bool(at_build) == bool([*value_problems(c.path, named)]), (c.path, path, x)


HALVED: Any = 0.5 * gb.Parameter("P", 1.8)
ALONE = {
    "a stiffness": (gb.Shaft(k=gb.Parameter("P", 100.0)), 0.0, r"'b2': k = 0.0 N m/rad \(Parameter.*'P'.* must be > 0"),
    "half a stiffness": (gb.Shaft(k=0.5 * gb.Parameter("P", 100.0)), -2.0, r"'b2': k = -1.0 N m/rad .* must be > 0"),
    "an end": (gb.Lash(k=1.0, lower=gb.Parameter("P", 0.0), upper=0.1), 0.5, r"lower = 0.5 rad must be <= upper = 0.1"),
    "a wave": (
        gb.SplineCoupling(**SPLINE, stiffness_variation=gb.Fourier(cos=(gb.Parameter("P", 0.5),))), 1.05,
        "'b2': stiffness_variation: in part of its cycle the stiffness is -0.05 times k",
    ),
    "an efficiency": (gb.LossyGear(ratio=2, efficiency=(HALVED, 0.9)), 0.0, r"efficiency\[0\] = 0.0 .* must be > 0"),
    "a stop": (
        gb.HardStop(lower=gb.Parameter("P", -0.1), upper=0.1, restitution=0.5), 0.2,
        r"must be < upper .*\(where P = 0.2\)",
    ),
    "a law of friction": (
        gb.BearingFriction(torque=gb.Parameter("P", 2.0) - 0.1 * gb.slip / (1 + gb.slip)), -1.0, "and must be >= 0",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ALONE)
def test_a_parameter_of_a_run_is_held_to_what_it_stands_in(name: str) -> None:
    block, value, words = ALONE[name]
    rig = _chain(gb.Torque(tau=1.0), gb.Inertia(J=1.0), block)
    if "b" in type(block).flanges:
        rig.connect(rig.add("b3", gb.Inertia(J=1.0)).a, rig["b2"].b)
    with pytest.raises(gb.ParameterError, match=words):
        parameter_vector(model_of(rig), {"P": value}, None)


def test_numbers_of_a_run_are_judged_together() -> None:
    """Both ends of a gap move; each alone would pass the other."""
    model = model_of(_between(COUPLINGS["gap with two ends"]))
    assert parameter_vector(model, {"b2.lower": 0.5, "b2.upper": 0.6}, None) is not None
    with pytest.raises(gb.ParameterError, match=r"Lash 'b2': lower = 0.7 rad must be <= upper = 0.6 rad"):
        parameter_vector(model, {"b2.lower": 0.7, "b2.upper": 0.6}, None)


def test_an_option_lifts_the_bound_and_what_varies_is_not_judged() -> None:
    free = model_of(_between(gb.Shaft(k=100.0, allow_negative=True)))
    assert _said(free, {"b2.k": -5.0}) == ""
    assert free.program.parameters[free.program.parameter_numbers["b2.k"]].lower is None
    bound = model_of(_between(gb.Shaft(k=100.0)))
    assert _said(bound, {"b2.k": -5.0}) == "b2.k = -5.0 N m/rad must be > 0 (or give allow_negative=True)"
    info = bound.program.parameters[bound.program.parameter_numbers["b2.k"]]
    assert (info.lower, info.open_lower) == (0, True)
    assert _said(model_of(_between(gb.Shaft(k=gb.Parameter("P", 1.0) * gb.sin(gb.time)))), {"P": -1.0}) == ""


MULTIPLES: dict[str, tuple[Callable[[gb.Parameter], Any], float | None, float | None]] = {
    "half": (lambda p: p / 2, 0.0, None),
    "less": (lambda p: -0.5 * p, None, 0.0),
    "with another": (lambda p: gb.Parameter("Q", 1.0) * p, None, None),
    "and more": (lambda p: 2 * p + 1, None, None),
}


@pytest.mark.parametrize("name", MULTIPLES)
def test_a_bound_of_0_is_one_of_what_is_multiplied_too(name: str) -> None:
    """So an FMU declares it, whose variable is the Parameter."""
    law, lower, upper = MULTIPLES[name]
    start = -100.0 if upper == 0 else 100.0
    model = model_of(_between(gb.Shaft(k=law(gb.Parameter("P", start)))))
    info = model.program.parameters[model.program.parameter_numbers["P"]]
    assert (info.lower, info.upper) == (lower, upper)
    assert (info.open_lower, info.open_upper) == (lower is not None, upper is not None)
    assert "must be > 0 (or give allow_negative=True)" in _said(model, {"P": -start})


def test_the_second_base_radius_follows_the_first() -> None:
    model = model_of(_between(COUPLINGS["impacts"]))
    assert _said(model, {"b2.r_base[0]": 0.5}) == ""
    assert _said(model, {"b2.r_base[0]": -0.5}) == "b2.r_base[0] = -0.5 m must be > 0"


def test_signals_over_all_time_are_asked_once() -> None:
    """Whether w is the rate of phi takes integrals; a run with another amplitude does not wait for them."""
    size = gb.Parameter("A", 1.0)
    parts = {"phi": size * gb.sin(gb.time), "w": size * gb.cos(gb.time), "alpha": -1.0 * size * gb.sin(gb.time)}
    model = model_of(_chain(gb.Angle(**parts), gb.Inertia(J=1.0)))
    assert _said(model, {"A": 2.0}) == ""
    assert [*gb.Angle(**parts).number_problems()] == []
    with pytest.raises(gb.ModelError, match="w"):
        _chain(gb.Angle(**{**parts, "w": gb.cos(2 * gb.time)}), gb.Inertia(J=1.0))


class _Pair(gb.Block):
    """A block of a user, which relates two numbers."""

    a = gb.Flange("shaft")
    low: Value = gb.param("least torque", "N m")
    high: Value = gb.param("largest torque", "N m")

    def problems(self) -> Iterator[str]:
        """Torques in the wrong order."""
        if isinstance(self.low, (int, float)) and isinstance(self.high, (int, float)) and self.low > self.high:
            yield f"low = {self.low:g} must be <= high = {self.high:g}"

    def physics(self, s: Any) -> Iterator[Any]:
        """The mean torque."""
        yield gb.Acts(s.a, (s.low + s.high) / 2)


def test_rules_of_a_users_block_hold_in_a_run_and_of_parameters() -> None:
    words = r"_Pair 'b1': low = 3 must be <= high = 2"
    with pytest.raises(gb.ParameterError, match=words):
        parameter_vector(model_of(_chain(gb.Inertia(J=1.0), _Pair(low=1.0, high=2.0))), {"b1.low": 3.0}, None)
    with pytest.raises(gb.ModelError, match=words):
        _chain(gb.Inertia(J=1.0), _Pair(low=gb.Parameter("P", 3.0), high=2.0))
