"""Bodies that impacts have brought to rest in their gaps, one on the other, until the load passes zero and all let go."""

import numpy as np
import pytest

import gearblocks as gb

# what differs: speed of the first body [rad/s], inertias, restitutions of both gaps
CASES = [
    (-8.57, (0.0217, 1.03, 0.312), (0.558, 0.304)),
    (-7.19, (0.0323, 1.25, 0.266), (0.566, 0.349)),
    (-6.72, (0.0324, 1.28, 0.370), (0.584, 0.281)),
    (-9.40, (0.0151, 1.47, 0.387), (0.521, 0.396)),
    (-9.79, (0.0353, 1.27, 0.444), (0.564, 0.288)),
    (-9.23, (0.0340, 1.42, 0.350), (0.522, 0.334)),
]
LOAD = gb.Table([0.0, 0.96, 1.71, 2.0], [0.0, 4.15, -4.15, 4.15])
IMPULSE = 0.5 * 4.15 * 0.96  # of the load over the 2 s: what follows adds nothing up to 1.71 s
ARMS = (0.02, 0.02 * 31 / 17)


def _train(w0, inertias, restitutions):
    rig = gb.Drivetrain("rests")
    left, middle, right = (
        rig.add(name, gb.Inertia(J=J, w0=w))
        for name, J, w in zip(("left", "middle", "right"), inertias, (None, w0, None), strict=True)
    )
    spline = rig.add(
        "spline",
        gb.SplineCoupling(
            teeth=4, radius=0.05, k=1e6, backlash=gb.Backlash(half_gap=1.56e-3),
            contact_damping=gb.HuntCrossley(restitution=restitutions[0]),
        ),
    )  # fmt: skip
    mesh = rig.add(
        "mesh",
        gb.GearMesh(
            teeth=(17, 31), external=False, r_base=ARMS, backlash=gb.Backlash(half_gap=3.34e-4),
            contact_damping=gb.HuntCrossley(restitution=restitutions[1]),
        ),
    )  # fmt: skip
    stop, load = rig.add("stop", gb.HardStop(restitution=1.0, lower=0.0)), rig.add("load", gb.Torque(tau=LOAD))
    rig.connect(left.a, spline.a)
    rig.connect(middle.a, spline.b, mesh.pinion)
    rig.connect(middle.b, stop.a, load.flange)
    rig.connect(right.a, mesh.wheel)
    return rig.without("spline.compliance")


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize(("w0", "inertias", "restitutions"), CASES)
@pytest.mark.few(3)
def test_they_let_go_and_keep_momentum_and_energy(w0, inertias, restitutions, method):
    """A gap is then its rounding, on either side, and grows with the third power of time. An impact in one gap that opens the
    other one for nothing shares its impulse with the body behind it."""
    model = gb.build(_train(w0, inertias, restitutions))
    arms = np.array([1.0, 1.0, ARMS[0] / ARMS[1]])
    for rtol in (1e-5, 1e-6, 1e-7, 1e-8):
        run = gb.simulate(model, t_end=1.71, method=method, rtol=rtol)
        speeds = np.array([run[f"{name}.w"][-1] for name in ("left", "middle", "right")])
        given = inertias[1] * w0 + run["stop.impulse"][-1] + IMPULSE
        assert (np.array(inertias) * arms * speeds).sum() == pytest.approx(given, rel=1e-11)
        assert run.energy.residual < 1e-13
        let_go = [e for e in run.events if e.kind == "state" and e.t > 1.3 and e.after == 0.0]
        assert "mesh.upper" in {e.component for e in let_go}
        assert [e.t for e in let_go] == pytest.approx([0.5 * (0.96 + 1.71)] * len(let_go), rel=1e-12)
