"""What friction holds moves by rounding alone, and so does what hangs on it: its energies balance by chance or not at all."""

import numpy as np
import pytest

import gearblocks as gb


def _held(behind, spring):
    """A planetary set whose ring a freewheel holds under load; on its carrier bodies behind one-way clutches and a spring."""
    rig = gb.Drivetrain("held")
    carrier, second = rig.add("carrier", gb.Inertia(J=0.25)), rig.add("second", gb.Inertia(J=0.224))
    clutch = rig.add("clutch", gb.OneWayClutch(capacity=3.0, peak=1.3))
    last, shaft = rig.add("last", gb.Inertia(J=behind)), rig.add("shaft", gb.Shaft(torque=spring, c=0.147))
    ring, sun = rig.add("ring", gb.Inertia(J=0.409)), rig.add("sun", gb.Inertia(J=1.01))
    planetary, freewheel = rig.add("set", gb.IdealPlanetary(ratio=1.5)), rig.add("freewheel", gb.Freewheel())
    load, ground = rig.add("load", gb.Torque(tau=38.0 * gb.sin(1.59 * gb.time))), rig.add("ground", gb.Fixed())
    rig.connect(carrier.a, clutch.b, planetary.carrier)
    rig.connect(second.a, clutch.a)
    rig.connect(second.b, shaft.a)
    rig.connect(last.a, shaft.b)
    rig.connect(ring.a, planetary.ring, freewheel.a)
    rig.connect(ring.b, load.flange)
    rig.connect(sun.a, planetary.sun)
    rig.connect(freewheel.b, ground.flange)
    return rig


SOFT_THEN_HARD = gb.Table([-0.0343, 0.0, 0.0343], [-44.6, 0.0, 22.3], kind="cubic")


@pytest.mark.parametrize("method", ["auto", "rodas", "dp5", "dp8"])
@pytest.mark.parametrize(("behind", "spring"), [(1.09, SOFT_THEN_HARD), (0.3, SOFT_THEN_HARD), (1.09, 2e3 * gb.twist)])
@pytest.mark.few(1)
def test_the_energy_of_what_hangs_on_rest_is_rounding(behind, spring, method):
    model = gb.build(_held(behind, spring))
    for rtol in (1e-4, 1e-6, 1e-8, 1e-9):
        run = gb.simulate(model, t_end=0.5, method=method, rtol=rtol)
        assert max(np.abs(run[f"{name}.w"]).max() for name in ("carrier", "second", "last", "sun")) < 1e-11
        assert run.energy.residual <= 10.0 * rtol
