"""Planetary gearboxes of models/planetary_sets.py: ratios, reflected inertia, torques and power of rigid sets."""

import importlib.util
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb


def _shipped():
    path = Path(__file__).parents[3] / "models" / "planetary_sets.py"
    spec = importlib.util.spec_from_file_location("planetary_sets_model", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


sets = _shipped()
RHO, A, B = Fraction(28, 70), Fraction(76, 30), Fraction(76, 36)
GEARS = [
    (sets.compound, (), 1 + Fraction(40 * 76, 20 * 16)),
    (sets.simpson, (1,), 2 + RHO),
    (sets.simpson, (2,), 1 + RHO),
    (sets.simpson, (3,), 1),
    (sets.simpson, (-1,), -1 / RHO),
    (sets.ravigneaux, (1,), A),
    (sets.ravigneaux, (2,), (A + B) / (1 + B)),
    (sets.ravigneaux, (3,), 1),
    (sets.ravigneaux, (4,), B / (1 + B)),
    (sets.ravigneaux, (-1,), -B),
]


@pytest.mark.parametrize(
    ("make", "gear", "ratio"),
    [
        # of every set the first gear and reverse in the quick tier
        pytest.param(*case, id=f"{case[0].__name__}{case[1]}", marks=[pytest.mark.long] if case[1] > (1,) else [])
        for case in GEARS
    ],
)
@pytest.mark.few(1)
def test_every_gear_has_its_ratio_and_its_reflected_inertia(make, gear, ratio):
    rig = make(*gear)
    run = gb.simulate(rig, t=[0.0, 0.3], rtol=1e-9)
    engine, load = run["engine.phi"][-1], run["load.phi"][-1]
    assert engine == pytest.approx(float(ratio) * load, rel=1e-15)  # exact gains, one multiplication each
    # one degree of freedom: tau = alpha sum J (w_i/w_engine)^2
    bodies = [name for name in ("engine", "load", "sun", "planet", "ring", "carrier", "ring1", "output", "carrier2",
              "small", "large", "short", "long") if f"{name}.w" in run.names]  # fmt: skip
    reflected = sum(rig[name].J * (run[f"{name}.w"][-1] / run["engine.w"][-1]) ** 2 for name in bodies)
    assert run["engine.alpha"][0] == pytest.approx(100.0 / reflected, rel=1e-13)
    assert engine == pytest.approx(100.0 / reflected * 0.3**2 / 2, rel=1e-12)
    assert run.energy.residual < 1e-12


@pytest.mark.long
def test_the_simple_set_of_meshes_is_the_ideal_planetary():
    """Sun 28, planet 21, ring 70 on a carrier, nothing held: two degrees of freedom, the same motion and torques."""
    start = {"sun": 30.0, "carrier": 5.0}
    runs = []
    for ideal in (True, False):
        rig = gb.Drivetrain("simple set")
        bodies = {
            n: rig.add(n, gb.Inertia(J=J, w0=start.get(n))) for n, J in (("sun", 0.1), ("carrier", 0.3), ("ring", 0.2))
        }
        if ideal:
            gear = rig.add("gear", gb.IdealPlanetary(ratio=70 / 28))
            for name, body in bodies.items():
                rig.connect(body.b, getattr(gear, name))
        else:
            planet = rig.add("planet", gb.Inertia(J=0.0))
            inner = rig.add("inner", gb.GearMesh(teeth=(28, 21), external=True))
            outer = rig.add("outer", gb.GearMesh(teeth=(21, 70), external=False))
            rig.chain(bodies["sun"], inner, planet, outer, bodies["ring"])
            rig.connect(inner.carrier, outer.carrier, bodies["carrier"].a)
        for name, tau in (("sun", 3.0), ("carrier", gb.sin(7 * gb.time))):
            rig.connect(rig.add(f"on_{name}", gb.Torque(tau=tau)).flange, bodies[name].a)
        runs.append(gb.simulate(rig, t=np.linspace(0, 2, 41), rtol=1e-11))
    for name in ("sun.phi", "carrier.w", "ring.w", "ring.alpha"):
        assert np.abs(runs[0][name] - runs[1][name]).max() <= 1e-10 * np.abs(runs[0][name]).max(), name
    torques = np.array([runs[0][f"gear.torque_{n}"] for n in ("sun", "carrier", "ring")])
    assert np.abs(torques.sum(axis=0)).max() <= 1e-13 * np.abs(torques).max()  # nothing stands on the ground
    assert np.allclose(torques[2], 2.5 * torques[0], rtol=1e-12)  # Willis: torques as 1 : ratio
