"""Stiffness of a mesh by the standard."""

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.geometry.involute import ToothPair, mesh_stiffness

A, M, Z, MU, J = np.deg2rad(20), 3e-3, (23, 41), 0.06, (2e-4, 5e-3)
W = 100.0


def _rig(external=True, turning=False, load=20.0, free=False, **fields):
    """Pinion and wheel turning at 100 rad/s under a balanced load."""
    rig = gb.Drivetrain("pair")
    sign = 1 if external else -1
    pinion = rig.add("pinion", gb.Inertia(J=J[0], w0=W))
    wheel = rig.add("wheel", gb.Inertia(J=J[1], w0=-sign * W * Z[0] / Z[1]))
    fields = {"module": M, "pressure_angle": A, "k": 2e8, **fields}
    mesh = rig.add("mesh", gb.GearMesh(teeth=Z if external else (Z[0], 73), external=external, **fields))
    rig.connect(pinion.a, mesh.pinion)
    rig.connect(wheel.a, mesh.wheel)
    if not free:
        rig.connect(rig.add("drive", gb.Torque(tau=load)).flange, pinion.b)
        rig.connect(rig.add("load", gb.Torque(tau=sign * load * Z[1] / Z[0])).flange, wheel.b)
    if turning:
        rig.connect(rig.add("carrier", gb.Inertia(J=0.01, w0=7.0)).a, mesh.carrier)
    return rig


@pytest.mark.parametrize("fields", [
    {},
    pytest.param({"helix_angle": np.deg2rad(18)}, marks=pytest.mark.long),
    {"profile_shift": (0.3, 0.1)},
    {"profile_shift": (0.2, -0.1), "addendum": 1.1, "helix_angle": np.deg2rad(-10)},
])  # fmt: skip
@pytest.mark.few(1)
def test_the_stiffness_of_the_standard_is_that_of_its_formula(fields):
    run = gb.simulate(_rig(k=None, stiffness="iso6336", face_width=0.02, **fields), t=[0.0], rtol=1e-6)
    shape = {("shifts" if name == "profile_shift" else name): value for name, value in fields.items()}
    true = mesh_stiffness(ToothPair(*Z, M, A, **shape), 0.02)
    assert run["mesh.stiffness"][0] == pytest.approx(true, rel=1e-13)  # the same operations in another order


def test_the_stiffness_of_the_standard_follows_its_parameters_without_a_new_model():
    model = gb.build(_rig(k=None, stiffness="iso6336", face_width=0.02, profile_shift=(0.3, 0.1)))
    for name, value in (("face_width", 0.03), ("module", 2e-3), ("profile_shift[0]", 0.5), ("pressure_angle", 0.4)):
        run = gb.simulate(model, t=[0.0], parameters={f"mesh.{name}": value})
        shape = {"module": M, "pressure_angle": A, "shifts": (0.3, 0.1)}
        width = 0.02
        if name == "face_width":
            width = value
        elif name == "profile_shift[0]":
            shape["shifts"] = (value, 0.1)
        else:
            shape[name] = value
        assert run["mesh.stiffness"][0] == pytest.approx(mesh_stiffness(ToothPair(*Z, **shape), width), rel=1e-13)


@pytest.mark.long
def test_an_internal_pair_has_the_stiffness_against_a_rack():
    run = gb.simulate(_rig(external=False, k=None, stiffness="iso6336", face_width=0.02), t=[0.0])
    assert run["mesh.stiffness"][0] == pytest.approx(mesh_stiffness(ToothPair(Z[0], -73, M, A), 0.02), rel=1e-13)


@pytest.mark.parametrize(("fields", "words"), [
    ({"k": None, "stiffness": "iso6336"}, "stiffness='iso6336' needs face_width"),
    ({"stiffness": "iso6336", "face_width": 0.02}, "k and stiffness are both given"),
    ({"k": None, "stiffness": "agma"}, "stiffness = 'agma' is not known"),
    ({"k": None, "stiffness": "iso6336", "face_width": 0.0}, "face_width = 0.0 m must be > 0"),
    ({"k": None, "stiffness": "iso6336", "face_width": 0.02, "helix_angle": 0.6}, "must be <= 30"),
    ({"k": None, "stiffness": "iso6336", "face_width": 0.02, "profile_shift": (0.0, 0.2)}, "of the smaller gear"),
    ({"profile_shift": (0.1,)}, "must be two numbers (x1, x2)"),
    ({"friction": gb.ToothFriction(mu=-0.1)}, "friction.mu = -0.1 must be >= 0"),
    ({"friction": gb.ToothFriction(mu=0.1, direction="x")}, "must be 'geometry' or 'square_wave'"),
    ({"friction": gb.ToothFriction(mu=0.1, direction="square_wave")}, "wave=... (a signal of +1 and -1) belong"),
    ({"friction": gb.ToothFriction(mu=0.1, wave=1.0)}, "belong together"),
    ({"friction": gb.ToothFriction(mu=0.1, flank="left")}, "must be 'drive' or 'coast'"),
    ({"friction": gb.ToothFriction(mu=0.1), "addendum": 2.0}, "contact ratio is 2.9"),
    ({"friction": gb.ToothFriction(mu=0.1), "k": None}, "friction needs compliance"),
    ({"module": None, "pressure_angle": None, "r_base": (0.023, 0.041), "friction": gb.ToothFriction(mu=0.1)},
     "friction needs module, pressure_angle"),
    ({"backlash": gb.Backlash(gaps=(0.1, 0.1))}, "backlash.gaps is for a spline"),
])  # fmt: skip
@pytest.mark.few(3)
def test_teeth_that_make_no_law_are_refused_with_the_reason(fields, words):
    with pytest.raises(gb.ModelError) as caught:
        _rig(**fields)
    assert words in str(caught.value), str(caught.value)
