"""Tables of two variables in laws: cells, splines, edges, energy, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import gearblocks as gb

W = np.array([0.0, 10.0, 25.0, 60.0])
U = np.array([0.0, 0.4, 1.0])
Z = np.array([[20.0, 45.0, 60.0], [12.0, 40.0, 70.0], [-5.0, 30.0, 66.0], [-20.0, 4.0, 35.0]])
NAN = float("nan")


def _probe(table: gb.Table2, w: float, u: float) -> float:
    """The torque that the table gives at a speed and a throttle."""
    rig = gb.Drivetrain("probe")
    throttle = gb.Parameter("u", 0.0)
    rig.chain(rig.add("drive", gb.Torque(tau=table(gb.sense("body.w"), throttle))), rig.add("body", gb.Inertia(J=1.0)))
    run = gb.simulate(rig, t_end=1e-9, initial={"body.w": w}, parameters={"u": u})
    return float(run["drive.torque"][0])


POINTS = [(3.0, 0.1), (12.0, 0.4), (25.0, 0.9), (59.0, 0.99), (0.0, 0.0), (60.0, 1.0)]


@pytest.mark.parametrize(("w", "u"), [*POINTS, (-5.0, 0.2), (80.0, 0.2), (30.0, -1.0), (30.0, 2.0), (99.0, 9.0)])
@pytest.mark.few(3)
def test_a_linear_map_is_bilinear_in_its_cells_and_held_outside(w: float, u: float) -> None:
    along = [np.interp(u, U, row) for row in Z]
    assert _probe(gb.Table2(W, U, Z), w, u) == pytest.approx(np.interp(w, W, along), rel=1e-14, abs=1e-13)


@pytest.mark.parametrize(("w", "u"), [*POINTS, (-5.0, 0.2), (80.0, 0.2), (30.0, -1.0), (30.0, 2.0)])
@pytest.mark.few(3)
def test_a_cubic_map_is_the_product_of_two_flat_ended_splines(w: float, u: float) -> None:
    at = (np.clip(w, W[0], W[-1]), np.clip(u, U[0], U[-1]))
    rows = CubicSpline(U, Z, axis=1, bc_type="clamped")(at[1])
    expected = float(CubicSpline(W, rows, bc_type="clamped")(at[0]))
    assert _probe(gb.Table2(W, U, Z, kind="cubic"), w, u) == pytest.approx(expected, rel=1e-13, abs=1e-12)


def _run_up(table: gb.Table2, **options: object) -> gb.Trajectory:
    rig = gb.Drivetrain("run-up")
    throttle = 0.2 + 0.15 * gb.time
    rig.chain(
        rig.add("drive", gb.Torque(tau=table(gb.sense("body.w"), throttle))), rig.add("body", gb.Inertia(J=1.5, w0=1.0))
    )
    return gb.simulate(rig, t=np.linspace(0, 4, 41), **options)  # type: ignore[arg-type]


def test_a_run_across_the_cells_of_a_linear_map_is_exact(reference, distance):
    def rates(t, y, modes):
        return (np.interp(y[0], W, [np.interp(0.2 + 0.15 * t, U, row) for row in Z]) / 1.5,)

    lines = lambda t, y: (y[0] - 10.0, y[0] - 25.0, 0.2 + 0.15 * t - 0.4)  # noqa: E731
    true = reference(rates, (1.0,), np.linspace(0, 4, 41), lines)
    run = _run_up(gb.Table2(W, U, Z), rtol=1e-11)
    assert distance(run["body.w"], true[:, 0]) < 1e-10  # tens of steps, corners located
    assert run["body.w"][-1] > 60.0  # all cells of the speed, and past the edge
    crossed = [e.t for e in run.events]
    assert len(crossed) == 4  # speeds 10, 25, 60; throttle 0.4
    assert any(abs(t - 4 / 3) < 1e-12 for t in crossed)


@pytest.mark.long
def test_order_is_kept_across_the_cells() -> None:
    true = _run_up(gb.Table2(W, U, Z, kind="cubic"), rtol=1e-12)["body.w"][-1]
    errors = [
        abs(_run_up(gb.Table2(W, U, Z, kind="cubic"), method="rk4", step=h)["body.w"][-1] - true) for h in (0.1, 0.05)
    ]
    assert errors[1] < errors[0] / 10  # order 4 gives 16; corners that are not located give 2 to 4


@pytest.mark.long
def test_a_map_survives_its_file(tmp_path: Path) -> None:
    rig = gb.Drivetrain("stored")
    table = gb.Table2(W, U, Z, kind="cubic")
    rig.chain(rig.add("drive", gb.Torque(tau=table(gb.sense("body.w"), 0.5) + 1)), rig.add("body", gb.Inertia(J=2.0)))
    rig.to_json(tmp_path / "rig.json")
    again = gb.Drivetrain.from_json(tmp_path / "rig.json")
    assert gb.build(again).program.key == gb.build(rig).program.key
    assert repr(again["drive"]) == repr(rig["drive"])
    assert table == gb.Table2(W, U, Z, kind="cubic") != gb.Table2(W, U, Z)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((W, U, Z.T), r"x \(4,\), y \(3,\) and z \(3, 4\) must be"),
        (([1.0], U, [[1, 2, 3]]), "must be rows of n and m >= 2"),
        ((W[::-1], U, Z), "x must increase"),
        ((W, [0, 0, 1], Z), "y must increase"),
        ((W, U, np.where(Z == 4.0, NAN, Z)), r"z\[3\]\[1\] = nan must be a finite number"),
        (([0, 1, 2, NAN], U, Z), r"x\[3\] = nan must be a finite number"),
        (("abcd", U, Z), "x = 'abcd' must be rows of numbers"),
        ((W, U, [[1, 2], [3]]), "z = .* must be rows of numbers"),
        ((W, U, Z, "step"), "kind = 'step' must be 'linear' or 'cubic'"),
    ],
)
@pytest.mark.few(3)
def test_a_bad_map_is_refused_in_words(arguments: tuple, words: str) -> None:
    with pytest.raises(gb.ParameterError, match=words):
        gb.Table2(*arguments)


def test_a_map_alone_is_no_signal() -> None:
    rig = gb.Drivetrain("bare")
    with pytest.raises(gb.ModelError, match=r"tau = Table2.*call it with two quantities"):
        rig.add("drive", gb.Torque(tau=gb.Table2(W, U, Z)))


def test_a_map_reads_as_a_function_of_its_quantities_in_the_equations() -> None:
    rig = gb.Drivetrain("rig")
    rig.chain(rig.add("motor", gb.Engine(torque_map=gb.Table2(W, U, Z), throttle=0.5)), rig.add("a", gb.Inertia(J=1.0)))
    assert "J_a φ_a'' = T_motor(φ_a', u_motor)" in str(rig.equations())
