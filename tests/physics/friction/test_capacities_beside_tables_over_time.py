"""Constraint forces are searched for where they leave their bounds, whatever else the train knows of time."""

import math

import pytest

import gearblocks as gb


@pytest.mark.parametrize("tables", [0, 1, 2, 4, 7])
def test_a_brake_lets_go_beside_tables_over_time(tables):
    """Limits of switches of time were written behind the numbers of event functions, and excused a force that was beyond its
    bound by as much as a knot of a table is seconds."""
    rig = gb.Drivetrain("fading brake")
    body = rig.add("body", gb.Inertia(J=1.0))
    brake = rig.add("brake", gb.Brake(capacity=4.0 * gb.exp(-gb.time)))
    rig.connect(body.a, brake.a)
    rig.connect(body.b, rig.add("load", gb.Torque(tau=1.0)).flange)
    for i in range(tables):
        knots = [0.0, 0.3 + 0.1 * i, 0.9 + 0.05 * i, 5.0]
        idle = rig.add(f"table{i}", gb.Torque(tau=gb.Table(knots, [0.0, 0.1, -0.1, 0.0])))
        rig.connect(rig.add(f"other{i}", gb.Inertia(J=1.0)).a, idle.flange)
    model = gb.build(rig)
    for method in ("auto", "dp5", "dp8", "rodas"):
        for rtol in (1e-4, 1e-8):
            run = gb.simulate(model, t_end=3.0, method=method, rtol=rtol)
            leaves = [e.t for e in run.events if e.component == "brake" and e.t > 0.1]
            assert leaves == [pytest.approx(math.log(4.0), abs=10 * rtol)], (method, rtol)
