"""Work of sources whose law has conditions: that of closed forms, in every mode and whatever is true at the start."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

T, W, PHI = gb.time, gb.sense("body.w"), gb.sense("body.phi")
A, B = gb.Parameter("A", 4.0), gb.Parameter("B", 0.0)


def _body(tau, *, w0=0.0, J=2.0):
    rig = gb.Drivetrain("one body")
    rig.chain(rig.add("drive", gb.Torque(tau=tau)), rig.add("body", gb.Inertia(J=J, w0=w0)))
    return rig


# torque on J = 2 kg m2, speed at the start and after 2 s
QUICK = (
    "a window", "a governor", "until an angle", "a window of speed and time", "a sign", "a table from a corner on",
    "a narrow hill",
)  # fmt: skip
SOURCES = {
    "a step": (gb.piecewise((A, T > 0.5), (0, True)), 0.0, 3.0),
    "a ramp": (gb.piecewise((100 * (T - 0.5), T > 0.5), (0, True)), 0.0, 56.25),
    "a window": (gb.piecewise((0, T < 0.2), (A, T < 0.7), (0, True)), 1.0, 2.0),
    "a governor": (gb.piecewise((5 * (80 - W), W < 80), (0, True)), 0.0, 80 * (1 - np.exp(-5.0))),
    "a governor from above": (gb.piecewise((-3, W > 4), (0, True)), 5.0, 4.0),
    "until an angle": (gb.piecewise((9, PHI < 4), (0, True)), 0.0, 6.0),
    "a window of speed and time": (gb.piecewise((A, sp.And(T > 0.5, W < 2)), (0, True)), 0.0, 2.0),
    "either of two": (gb.piecewise((0, sp.Or(T < 0.5, W > 2)), (A, True)), 0.0, 2.0),
    "a sign": (-3 * (1 + sp.sign(W - 1)), 5.0, 1.0),
    "the positive part": (sp.Max(0, T - 1) * 8, 0.0, 2.0),
    "a table from a corner on": (gb.Table([0, 1, 2], [0, 0, 6])(T), 0.0, 1.5),
    # what is exactly 0 in floating point nearly everywhere
    "a narrow pulse": (100 * gb.exp(-(((T - 1.3) / 0.01) ** 2)), 1.0, 1.0 + 0.5 * np.sqrt(np.pi)),
    "a narrow hill": (30 * gb.exp(-(((PHI - 3) / 0.01) ** 2)), 2.0, np.sqrt(4 + 0.3 * np.sqrt(np.pi))),
    "a smooth step": (A / 2 * (1 + gb.tanh((T - 1.5) / 0.005)), 0.0, 1.0),
}


@pytest.mark.parametrize(
    ("name", "forward"),
    [pytest.param(name, True, marks=[pytest.mark.long] * (name not in QUICK)) for name in SOURCES]
    + [pytest.param(name, False, marks=[pytest.mark.long] * (name != "a governor")) for name in SOURCES],
)
@pytest.mark.few(1)
def test_the_work_of_a_source_with_conditions_is_the_energy_that_its_body_gains(name, forward):
    tau, start, end = SOURCES[name]
    rig = _body(tau, w0=start)
    if not forward:  # the same seen from the other side of a reversing gear
        rig = gb.Drivetrain("mirrored")
        drive, gear = rig.add("drive", gb.Torque(tau=tau)), rig.add("gear", gb.IdealGear(ratio=-1))
        rig.chain(drive, gear, rig.add("mirror", gb.Inertia(J=1.5, w0=-start)))
        rig.connect(drive.flange, rig.add("body", gb.Inertia(J=0.5, w0=start)).a)
    for method in ("dp8", "dp5"):
        run = gb.simulate(rig, t_end=2.0, rtol=1e-8, method=method, residual=1e-7)
        work = end**2 - start**2
        assert run["body.w"][-1] == pytest.approx(end, rel=1e-7)
        assert run.energy.supplied["drive"] == pytest.approx(work, rel=1e-7, abs=1e-6)


@pytest.mark.parametrize(
    "tau",
    [
        gb.piecewise((A, B > 5), (0, True)),
        gb.piecewise((A * T / 2, sp.And(B > 5, T < 1)), (A / 2, B > 6), (0, True)),
        A * sp.Max(0, sp.Min(B, 1)),
        B * A / 10,
    ],
    ids=["condition", "with time", "limits", "factor"],
)
@pytest.mark.few(2)
def test_a_parameter_that_turns_a_source_on_later_turns_its_work_on(tau):
    model = gb.build(_body(tau))
    off, on = gb.simulate(model, t_end=2.0), gb.simulate(model, t_end=2.0, parameters={"B": 10.0})
    assert off.energy.supplied["drive"] == 0.0 and off["body.w"][-1] == 0.0
    assert on["body.w"][-1] > 0.5
    assert on.energy.supplied["drive"] == pytest.approx(on["body.w"][-1] ** 2, rel=1e-5)
    assert on.energy.residual < 1e-5
