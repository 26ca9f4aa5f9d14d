"""Trains inside trains: they turn as if spelled out, and inputs and senses belong to the copy they stand in."""

import numpy as np

import gearblocks as gb


def _cell() -> gb.Drivetrain:
    cell = gb.Drivetrain("cell")
    body = cell.add("body", gb.Inertia(J=1.0))
    push = cell.add("push", gb.Torque(tau=gb.Input("u") - 2 * gb.sense("body.w")))
    cell.connect(push.flange, body.b)
    cell.expose("end", body.a)
    return cell


def test_inputs_and_senses_of_two_copies_are_their_own():
    rig = gb.Drivetrain("two cells")
    one, two = rig.add("one", _cell()), rig.add("two", _cell())
    rig.chain(one, rig.add("shaft", gb.Shaft(k=1e-9)), two)
    assert [x.name for x in gb.build(rig).program.inputs] == ["one.u", "two.u"]
    run = gb.simulate(rig, t=[0.0, 1.0], inputs={"one.u": 3.0, "two.u": -1.0}, rtol=1e-10)
    # w' = u - 2 w, the shaft too soft to matter at 1e-9
    expected = (1 - np.exp(-2.0)) / 2
    np.testing.assert_allclose([run["one.body.w"][1], run["two.body.w"][1]], [3 * expected, -expected], rtol=1e-8)


NEAR = 1e-9  # hundreds of steps at rtol 1e-12, the same equations in another order


def test_a_train_inside_a_train_turns_as_if_it_were_spelled_out(distance):
    inner = gb.Drivetrain("stage")
    pinion = inner.add("pinion", gb.Inertia(J=1e-3))
    mesh = inner.add("mesh", gb.GearMesh(teeth=(20, 30), r_base=(0.02, 0.03), external=True, k=1e7, c=100.0))
    wheel = inner.add("wheel", gb.Inertia(J=3e-3))
    inner.chain(pinion, mesh, wheel)
    inner.expose("input", pinion.a)
    inner.expose("output", wheel.b)
    rig = gb.Drivetrain("two stages")
    one, two = rig.add("one", inner), rig.add("two", inner)
    shaft, drive = rig.add("shaft", gb.Shaft(k=2e3)), rig.add("drive", gb.Torque(tau=gb.Input("tau", 10.0)))
    rig.chain(drive, one, shaft, two)
    flat = gb.Drivetrain("flat")
    parts = [flat.add("drive", gb.Torque(tau=10.0))]
    for n in (1, 2):
        parts += [flat.add(f"pinion{n}", gb.Inertia(J=1e-3))]
        parts += [flat.add(f"mesh{n}", gb.GearMesh(teeth=(20, 30), r_base=(0.02, 0.03), external=True, k=1e7, c=100.0))]
        parts += [flat.add(f"wheel{n}", gb.Inertia(J=3e-3))]
        if n == 1:
            parts += [flat.add("shaft", gb.Shaft(k=2e3))]
    flat.chain(*parts)
    t = np.linspace(0, 0.02, 51)
    a, b = gb.simulate(rig, t=t, rtol=1e-12), gb.simulate(flat, t=t, rtol=1e-12)
    assert distance(a["two.mesh.force"], b["mesh2.force"]) < NEAR
    assert distance(a["one.pinion.w"], b["pinion1.w"]) < NEAR
    changed = rig.set({"two.mesh.k": 2e7})
    assert changed["two.mesh"].k == 2e7
    assert changed["one.mesh"].k == rig["two.mesh"].k == 1e7
    assert set(changed.without("two.*").effects()) == {"one.mesh.compliance", "one.mesh.damping", "shaft.compliance"}
