"""Start values that are given by Parameters follow them, however the Parameters are changed; those given beside stay."""

import numpy as np
import pytest

import fmu_export
import gearblocks as gb

SPEED = gb.Parameter("speed", 3000, "rpm")
RPM = np.pi / 30


def _pair(first, second, tie=None):
    rig = gb.Drivetrain("pair")
    a, b = rig.add("a", gb.Inertia(J=0.02, **first)), rig.add("b", gb.Inertia(J=0.02, **second))
    rig.chain(a, rig.add("tie", tie or gb.Shaft(k=1e3)), b)
    return rig


def _speeds(train, **settings):
    run = gb.simulate(train, t=[0.0], **settings)
    return run["a.w"][0], run["b.w"][0]


@pytest.mark.long
def test_expressions_follow_in_runs():
    model = gb.build(_pair({"w0": SPEED}, {"w0": -SPEED * 23 / 41}))
    assert _speeds(model) == pytest.approx((3000 * RPM, -3000 * RPM * 23 / 41), rel=1e-15)
    assert _speeds(model, parameters={"speed": 500}) == pytest.approx((500 * RPM, -500 * RPM * 23 / 41), rel=1e-15)
    assert _speeds(model, parameters={"speed": "10 rad/s"}) == pytest.approx((10, -10 * 23 / 41), rel=1e-15)


@pytest.mark.long
def test_angles_follow_too():
    twist = gb.Parameter("twist", 0.1, "rad")
    rig = _pair({"phi0": 2 * twist}, {"phi0": twist})
    run = gb.simulate(rig, t=[0.0], parameters={"twist": 0.3})
    assert (run["a.phi"][0], run["b.phi"][0]) == pytest.approx((0.6, 0.3), rel=1e-15)


@pytest.mark.parametrize("given", [({}, {"w0": SPEED}), ({}, {"w0": 1.0 * SPEED}), ({"w0": 2 * SPEED}, {"w0": SPEED})])
@pytest.mark.few(1)
def test_what_follows_through_ties_does_so_again(given):
    model = gb.build(_pair(*given, tie=gb.IdealGear(ratio=2.0)))
    assert _speeds(model, parameters={"speed": 500}) == pytest.approx((1000 * RPM, 500 * RPM), rel=1e-14)


@pytest.mark.long
def test_what_follows_on_a_dependent_group_is_solved_for_again():
    rig = gb.Drivetrain("set")
    gear = rig.add("gear", gb.IdealPlanetary(ratio=2.0))
    bodies = {name: rig.add(name, gb.Inertia(J=0.1)) for name in ("sun", "carrier")}
    ring = rig.add("ring", gb.Inertia(J=0.1, w0=SPEED / 2))
    for name, body in (*bodies.items(), ("ring", ring)):
        rig.connect(body.a, getattr(gear, name))
    run = gb.simulate(rig, t=[0.0], parameters={"speed": 600})
    sun, carrier, ring_speed = (run[f"{name}.w"][0] for name in ("sun", "carrier", "ring"))
    assert ring_speed == pytest.approx(300 * RPM, rel=1e-12)
    assert sun + 2.0 * ring_speed == pytest.approx(3.0 * carrier, rel=1e-12)


def test_studies_follow_from_point_to_point():
    model = gb.build(_pair({"w0": SPEED}, {"w0": -SPEED * 23 / 41}))
    quantity = [gb.at("a.w", 0.0), gb.at("b.w", 0.0)]
    study = gb.sweep(model, {"speed": [500, 1000, 6000]}, quantity=quantity, t_end=0.01)
    rpm = np.array([500, 1000, 6000]) * RPM
    assert study.values == pytest.approx(np.column_stack([rpm, -rpm * 23 / 41]), rel=1e-15)
    given = gb.sweep(model, {"speed": [500, 1000]}, quantity=quantity, t_end=0.01, initial={"b.w": 7.0})
    assert given.values[:, 1] == pytest.approx([7.0, 7.0], rel=1e-15)
    begun = gb.sweep(model, {"speed": [500], "b.w": [3.0, 4.0]}, quantity=quantity, t_end=0.01)
    assert begun.values[:, 1] == pytest.approx([3.0, 4.0], rel=1e-15)


@pytest.mark.long
def test_what_is_given_beside_stays():
    model = gb.build(_pair({"w0": SPEED}, {"w0": -SPEED}))
    assert _speeds(model, parameters={"speed": 500}, initial={"b.w": 7.0})[1] == 7.0
    assert _speeds(model, parameters={"speed": 500, "b.w0": 8.0})[1] == 8.0
    assert gb.build(_pair({"w0": 3.0}, {})).starts is None


def test_a_contradiction_is_said_by_name():
    model = gb.build(_pair({"w0": SPEED}, {"w0": 1500 * RPM}, tie=gb.IdealGear(ratio=2.0)))
    with pytest.raises(gb.ParameterError, match=r"'a': w0 = .* and 'b': w0 = .* contradict each other"):
        gb.simulate(model, t=[0.0], parameters={"speed": 500})


@pytest.mark.long
def test_an_fmu_says_what_does_not_follow(tmp_path):
    with pytest.warns(gb.GearblocksWarning, match=r"b\.w0 follow from speed here, but stay in an FMU as they are"):
        fmu_export.export(_pair({"w0": SPEED}, {"w0": -SPEED}), tmp_path / "pair.fmu")


@pytest.mark.long
def test_a_start_value_that_is_a_parameter_does_not_change_that():
    """It would have changed the other shaft and the frequency of the drive with it."""
    rig = _pair({"w0": SPEED}, {"w0": SPEED})
    rig.connect(rig["a"].a, rig.add("drive", gb.Torque(tau=gb.sin(SPEED * gb.time))).flange)
    with pytest.raises(
        gb.ParameterError, match=r"'a\.w' starts as the Parameter 'speed' says, .* parameters=\{'speed'"
    ):
        gb.simulate(rig, t=[0.0], initial={"a.w": 7.0})
    assert _speeds(rig, initial={"a.w": 3000 * RPM})[0] == pytest.approx(3000 * RPM)
    assert _speeds(_pair({"w0": SPEED}, {"w0": 1.0}), initial={"a.w": 7.0})[0] == 7.0  # nobody else reads it
