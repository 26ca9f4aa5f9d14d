"""Trains inside trains: inputs and senses belong to the copy they stand in."""

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


def test_a_continued_run_keeps_the_parameters_of_the_first():
    rig = gb.Drivetrain("push")
    rig.chain(rig.add("drive", gb.Torque(tau=1.0)), rig.add("body", gb.Inertia(J=1.0)))
    first = gb.simulate(rig, t_end=1.0, parameters={"body.J": 4.0})
    second = gb.simulate(rig, t_end=2.0, initial=first)
    assert second["body.alpha"][0] == 0.25
    assert abs(second["body.w"][-1] - 0.5) < 1e-15  # rounding of the sum of steps
