"""What the energies of a block leave unexplained, it supplies."""

import pytest

import gearblocks as gb
from gearblocks.laws.derivation import derive

MESH = {"teeth": (23, 41), "r_base": (0.03, 0.03 * 41 / 23), "external": True, "k": 2e8, "c": 300.0}
TEETH = {
    "teeth": (23, 73), "external": False, "module": 3e-3, "pressure_angle": 0.35, "stiffness": "iso6336",
    "face_width": 0.02, "profile_shift": (0.2, 0.1),
}  # fmt: skip
GAP = gb.Backlash(half_gap=3e-5)
PASSIVE = {
    "shaft": gb.Shaft(k=1e4, c=1.0),
    "nonlinear shaft": gb.Shaft(torque=100 * gb.twist + 1e4 * gb.twist**3, c=1.0),
    "damper": gb.Damper(c=1.0),
    "speed load": gb.SpeedLoad(coeffs=(1.0, 2.0, 3.0)),
    "mesh over the angle": gb.GearMesh(
        **MESH, stiffness_variation=gb.Fourier(cos=(0.2,)), transmission_error=gb.Harmonic(sin=(1e-6,)), backlash=GAP
    ),
    **{
        f"lash, {choice}": gb.Lash(k=1e3, half_gap=0.1, c=2.0, contact_damping=choice)
        for choice in ("clipped", "clipped_force", "always")
    },
    "polynomial gap": gb.GearMesh(
        **MESH, contact_damping="always", backlash=gb.Backlash(half_gap=3e-5, law="polynomial", degree=9)
    ),
    "smooth gap": gb.GearMesh(**MESH, backlash=gb.Backlash(half_gap=3e-5, law="smooth", width=1e-6)),
    "a gap of every tooth": gb.SplineCoupling(
        teeth=3, radius=0.03, k=1e8, c=10.0, backlash=gb.Backlash(gaps=(1e-5, 3e-5, 2e-5))
    ),
    "clutch": gb.Clutch(mu=gb.Table([0, 1], [0.5, 0.4]), force_max=3.0, engagement=gb.time),
    "bearing": gb.BearingFriction(coulomb=1.0, viscous=0.1, stribeck=gb.Stribeck(rise=0.3, speed=2.0)),
    "one way clutch": gb.OneWayClutch(mu=0.5, force_max=3.0, engagement=gb.time),
    "synchroniser": gb.Synchronizer(capacity=gb.time, engaged=gb.time),
    "stops": gb.HardStop(lower=-1.0, upper=1.0, restitution=0.5),
    "rolling vehicle": gb.Vehicle(mass=1e3, wheel_radius=0.3, drag_area=0.7, rolling=0.01),
    "dry slider": gb.Shaft(k=1e3, hysteresis=gb.Hysteresis(friction=1.0)),
    "slider and spring": gb.Shaft(k=1e3, c=1.0, hysteresis=gb.Hysteresis(friction=1.0, stiffness=1e2)),
    "impacts": gb.Lash(k=1e3, half_gap=0.1, contact_damping=gb.HuntCrossley(restitution=0.5)),
    **{
        f"tooth friction, {flank}, {transition}": gb.GearMesh(
            **TEETH, backlash=GAP, c=300.0, friction=gb.ToothFriction(mu=0.1, flank=flank, transition=transition)
        )
        for flank in ("drive", "coast")
        for transition in (None, 0.1)
    },
}


class Leaky(gb.Block):
    """A damper that claims to lose half of what it takes."""

    a, b = gb.Flange("left"), gb.Flange("right")
    c: float = gb.param("damping", "N m s/rad")

    def physics(self, s):
        rate = s.b.w - s.a.w
        yield gb.Force(s.b.phi - s.a.phi, s.c * rate)
        yield gb.Energy(loss=s.c * rate**2 / 2)


def _law(block):
    return derive(block, frozenset(name for name, flange in type(block).flanges.items() if flange.ground))


MANY = ("tooth friction, drive, 0.1", "tooth friction, coast, None")


@pytest.mark.parametrize(
    "block", [pytest.param(b, id=n, marks=[pytest.mark.long] * (n in MANY)) for n, b in PASSIVE.items()]
)
@pytest.mark.few(8)
def test_a_passive_block_supplies_nothing(block):
    assert _law(block).supplied is None


@pytest.mark.parametrize(
    "block",
    [
        Leaky(c=1.0),
        gb.GearMesh(**MESH, stiffness_variation=gb.Fourier(cos=(0.2,), driven_by=500.0)),
        gb.Torque(tau=1.0),
        gb.GearMesh(**MESH, friction=gb.ToothFriction(mu=0.1, direction="square_wave", wave=gb.sin(gb.time))),
    ],
    ids=["wrong loss", "parametric", "source", "square wave"],
)
def test_what_the_energies_do_not_explain_is_supplied(block):
    assert _law(block).supplied is not None
