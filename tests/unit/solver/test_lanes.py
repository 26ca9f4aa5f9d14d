"""Points side by side in lanes have the bits of single runs that locate nothing."""

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.errors import CompileError
from gearblocks.solver.lanes import Lanes, LaneSteps

STEPS = 300


def _pair(shared: bool = True) -> gb.Drivetrain:
    """A gear pair with play; its torque has the frequency of the stiffness, or one of its own."""
    rig = gb.Drivetrain("pair")
    w = gb.Parameter("w", 900.0, "rad/s")
    body = rig.add("body", gb.Inertia(J=2e-3, phi0=1e-5))
    wheel = rig.add("wheel", gb.Inertia(J=5e-3))
    mesh = rig.add(
        "mesh",
        gb.SplineCoupling(
            teeth=20, radius=0.03, k=2e7, c=40.0, stiffness_variation=gb.Fourier(cos=(0.2,), driven_by=w),
            backlash=gb.Backlash(half_gap=2e-5),
        ),
    )  # fmt: skip
    drive = rig.add("drive", gb.Torque(tau=12.0 * (1 + 1.5 * gb.cos((w if shared else 777.0) * gb.time))))
    rig.chain(drive, body, mesh, wheel, rig.add("load", gb.Torque(tau=-12.0)))
    return rig


def _ring() -> gb.Drivetrain:
    """Shafts around a loop, one of them with play, with damping to the ground and a law of sines."""
    rig = gb.Drivetrain("ring")
    bodies = [rig.add(f"body{i}", gb.Inertia(J=0.02 + 0.01 * i, w0=1.0 - i)) for i in range(3)]
    for i in range(3):
        rig.connect(
            (
                s := rig.add(
                    f"shaft{i}", gb.Lash(k=300.0, c=0.2, half_gap=0.01) if i == 0 else gb.Shaft(k=300.0 + 50 * i, c=0.2)
                )
            ).a,
            bodies[i].a,
        )
        rig.connect(s.b, bodies[(i + 1) % 3].a)
    drive = rig.add("drive", gb.Torque(tau=gb.Input("tau", start=3.0, unit="N m")))
    rig.connect(drive.flange, bodies[1].a)
    return rig


TRAINS = {"pair": (_pair, "mesh.k", 2e-5), "ring": (_ring, "body1.J", 1e-3)}


def _points(model, path, count):
    """Parameter vectors in which one number grows from point to point."""
    place = model.program.parameter_numbers[path]
    rows = np.tile(model.values, (count, 1))
    rows[:, place] *= np.linspace(0.5, 1.5, count)
    return rows, rows[:, place].tolist()


def _all(model, rows, step, threads=1, **how):
    lanes = Lanes(model, range(len(model.program.outputs)))
    steps = np.broadcast_to(step, len(rows)).astype(float)
    return lanes.run(rows, steps, model.program.input_starts, LaneSteps(**({"steps": STEPS} | how)), threads)


@pytest.mark.numeric
@pytest.mark.parametrize("name", TRAINS)
@pytest.mark.few(1)
def test_every_output_at_every_step_has_the_bits_of_a_single_run(name):
    make, path, step = TRAINS[name]
    model = gb.build(make())
    rows, values = _points(model, path, 5)
    found = _all(model, rows, step, stride=1)
    for point, value in enumerate(values):
        run = gb.simulate(
            model, t=step * np.arange(STEPS + 1), method="rk4", step=step, locate=False, parameters={path: value}
        )
        for number, output in enumerate(run):
            np.testing.assert_array_equal(found.samples[point, :, number], run[output], err_msg=output)
        assert any(e.component for e in run.events) or name == "ring"


def test_neither_the_number_of_points_nor_their_order_nor_threads_change_a_bit():
    model = gb.build(_pair())
    rows, _ = _points(model, "mesh.k", 70)
    whole, turned = _all(model, rows, 2e-5), _all(model, rows[::-1], 2e-5, threads=2)
    few = _all(model, rows[33:36], 2e-5)
    for part in ("largest", "least", "mean", "rms", "last"):
        np.testing.assert_array_equal(getattr(whole, part), getattr(turned, part)[::-1])
        np.testing.assert_array_equal(getattr(whole, part)[33:36], getattr(few, part))


def test_extremes_and_means_are_those_of_the_steps_that_count():
    model = gb.build(_pair())
    rows, _ = _points(model, "mesh.k", 3)
    found = _all(model, rows, 2e-5, first=100, stride=1)
    x = found.samples
    assert x.shape == (3, STEPS - 100 + 1, len(model.program.outputs))
    np.testing.assert_array_equal(found.largest, x.max(axis=1))
    np.testing.assert_array_equal(found.least, x.min(axis=1))
    whole = np.abs(x).max(axis=1)
    assert (abs(found.mean - np.trapezoid(x, axis=1) / (STEPS - 100)) <= 1e-13 * whole).all()
    assert (abs(found.rms - np.sqrt(np.trapezoid(x**2, axis=1) / (STEPS - 100))) <= 1e-13 * whole).all()
    sparse = _all(model, rows, 2e-5, first=100, stride=50)
    np.testing.assert_array_equal(sparse.samples, x[:, ::50])


def test_an_excitation_that_repeats_is_computed_once():
    model = gb.build(_pair())
    rows, _ = _points(model, "w", 4)
    step = 2 * np.pi / rows[:, model.program.parameter_numbers["w"]] / 50
    stepwise, tabulated = (_all(model, rows, step, steps=200, period=period) for period in (0, 50))
    # the sides change some ten times on the way: rounding of the phase (1e-15) grows by much less than a thousand
    assert (abs(tabulated.last - stepwise.last) <= 1e-11 * abs(stepwise.last).max(axis=0)).all()
    assert not np.array_equal(tabulated.last, stepwise.last)


@pytest.mark.long
def test_an_excitation_that_does_not_repeat_is_computed_step_by_step():
    model = gb.build(_pair(shared=False))
    rows, _ = _points(model, "w", 4)
    step = 2 * np.pi / rows[:, model.program.parameter_numbers["w"]] / 50
    stepwise, asked = (_all(model, rows, step, steps=200, period=period) for period in (0, 50))
    np.testing.assert_array_equal(asked.last, stepwise.last)


@pytest.mark.long
def test_a_period_fills_its_table_and_a_longer_one_has_none():
    model = gb.build(_pair())
    rows, _ = _points(model, "w", 4)
    for period, is_kept in ((2048, True), (2049, False)):
        step = 2 * np.pi / rows[:, model.program.parameter_numbers["w"]] / period
        stepwise, asked = (_all(model, rows, step, steps=2 * period, period=p) for p in (0, period))
        assert (abs(asked.last - stepwise.last) <= 1e-9 * abs(stepwise.last).max(axis=0)).all()
        assert np.array_equal(asked.last, stepwise.last) != is_kept


def test_a_point_that_blows_up_leaves_its_neighbours_alone():
    model = gb.build(_pair())
    rows, _ = _points(model, "mesh.k", 8)
    sick = rows.copy()
    sick[3, model.program.parameter_numbers["mesh.k"]] = 1e19
    well, found = _all(model, rows, 2e-5), _all(model, sick, 2e-5)
    assert not np.isfinite(found.last[3]).all()
    others = [i for i in range(8) if i != 3]
    np.testing.assert_array_equal(found.last[others], well.last[others])


def test_a_train_that_sticks_has_no_lanes():
    rig = gb.Drivetrain("stopped by a brake")
    body = rig.add("body", gb.Inertia(J=1.0, w0=1.0))
    rig.chain(body, rig.add("brake", gb.Brake(capacity=1.0)))
    model = gb.build(rig)
    assert model.program.lanes == ""
    with pytest.raises(CompileError, match="stopped by a brake"):
        Lanes(model, [0])
