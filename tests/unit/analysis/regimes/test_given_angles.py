"""An angle that a source of speed gives: whatever reads it, nothing of an orbit is beside it."""

import numpy as np
import pytest

import gearblocks as gb

SPEED = gb.Parameter("speed", 314.0, "rad/s")


def _pair(variation, behind_a_shaft=False, speed=SPEED):
    rig = gb.Drivetrain("pair")
    parts = [rig.add("drive", gb.Speed(w=speed))]
    if behind_a_shaft:
        parts += [rig.add("motor", gb.Inertia(J=0.02, w0=SPEED)), rig.add("shaft", gb.Shaft(k=2e4, c=3.0))]
    mesh = gb.GearMesh(
        teeth=(23, 41), module=3e-3, pressure_angle=np.radians(20), external=True, k=2e8, damping_ratio=0.05,
        stiffness_variation=variation,
    )  # fmt: skip
    parts += [
        rig.add("pinion", gb.Inertia(J=2e-4, w0=SPEED)), rig.add("mesh", mesh),
        rig.add("wheel", gb.Inertia(J=0.005, w0=-SPEED * 23 / 41)), rig.add("load", gb.Torque(tau=100.0)),
    ]  # fmt: skip
    rig.chain(*parts)
    return rig


@pytest.mark.parametrize("behind_a_shaft", [False, True])
@pytest.mark.parametrize("cos", [(0.2,), (0.05, 0.02)])
@pytest.mark.few(1)
def test_what_varies_with_a_given_angle_has_the_orbit_of_what_varies_with_time(cos, behind_a_shaft):
    section = gb.stroboscopic("speed")
    over_time = _pair(gb.Fourier(cos=cos, driven_by=23 * SPEED), behind_a_shaft)
    over_angle = _pair(gb.Fourier(cos=cos), behind_a_shaft)
    right, found = (gb.classify(rig, section, initial="static") for rig in (over_time, over_angle))
    assert right.label == found.label == "period 1"
    assert found.orbit.neutral == (f"given angle of {'motor' if behind_a_shaft else 'pinion'}",)
    assert right.orbit.neutral == ()
    assert len(found.orbit.multipliers) == len(right.orbit.multipliers)
    np.testing.assert_allclose(abs(found.orbit.multipliers), abs(right.orbit.multipliers), rtol=1e-4, atol=1e-9)


@pytest.mark.long
def test_exponents_are_those_beside_the_given_angle():
    section = gb.stroboscopic("speed")
    right, found = (
        gb.lyapunov(_pair(variation), section, initial="static", periods=100)
        for variation in (gb.Fourier(cos=(0.2,), driven_by=23 * SPEED), gb.Fourier(cos=(0.2,)))
    )
    np.testing.assert_allclose(found.values, right.values, rtol=1e-3)


@pytest.mark.long
def test_a_speed_that_varies_gives_its_angle_too():
    speed = SPEED * (1 + 0.02 * gb.sin(SPEED * gb.time))
    found = gb.classify(_pair(gb.Fourier(cos=(0.2,)), speed=speed), gb.stroboscopic("speed"), initial="static")
    assert (found.label, found.orbit.neutral) == ("period 1", ("given angle of pinion",))


@pytest.mark.parametrize("method", ["dp8", "dp5", "rodas", "auto"])
@pytest.mark.few(1)
def test_a_run_goes_on_late_at_a_whole_turn(method):
    """The angle is then rounding of its turn, and so is what its rate says of a first step: less than time is told to."""
    model = gb.build(_pair(gb.Fourier(cos=(0.2,))))
    late = 400 * 2 * np.pi / 314.0
    before = gb.simulate(model, t_end=late, rtol=1e-10, initial="static", outputs=["pinion.phi", "mesh.force"])
    assert abs(before["pinion.phi"][-1] - 400 * 2 * np.pi) < 1e-9
    t = late + np.linspace(0.0, 0.02, 101)
    whole = gb.simulate(
        model, t=np.append(0.0, t), rtol=1e-9, initial="static", outputs=["mesh.force"]
    )["mesh.force"][1:]  # fmt: skip
    right = gb.simulate(model, t=t, rtol=1e-11, method=method, initial=before, outputs=["mesh.force"])
    largest = np.abs(whole).max()
    assert np.abs(right["mesh.force"] - whole).max() < 1e-6 * largest
    for rtol in (1e-6, 1e-8):
        run = gb.simulate(model, t=t, rtol=rtol, method=method, initial=before, outputs=["mesh.force"])
        assert np.abs(run["mesh.force"] - right["mesh.force"]).max() < 20 * rtol * largest
