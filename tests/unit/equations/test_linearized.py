"""Linearised equations: their matrices are the slopes of the forcing, printed in the notation of the equations."""

import random

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.cli import scripts
from gearblocks.equations.document import WIDTH
from gearblocks.equations.equations import inserted
from gearblocks.equations.linearized import _diff, linearized
from gearblocks.laws.functions import DeadZone
from tests.random.description import build
from tests.random.families import draw

MODELS = ["spline_coupling:build", "planetary_backlash:build", "limited_slip_differential:build", "dual_clutch:build"]


def mesh_on_a_shaft(**effects):
    rig = gb.Drivetrain("rig")
    pair = gb.GearMesh(teeth=(23, 41), module=0.003, pressure_angle=0.35, external=True, k=2e8, c=900.0, **effects)
    rig.chain(
        rig.add("drive", gb.Torque(tau=20.0)), rig.add("pinion", gb.Inertia(J=2e-4)), rig.add("mesh", pair),
        rig.add("wheel", gb.Inertia(J=0.05)), rig.add("shaft", gb.Shaft(k=3e4, c=2.0)), rig.add("hub", gb.Inertia(J=0.01)),
    )  # fmt: skip
    return rig


def numbers(expressions, values):
    """Expressions at a point."""
    spelled = [e.replace(DeadZone, lambda *args: DeadZone(*args).spelled_out()) for e in expressions]
    return np.array([float(e.xreplace(values)) for e in spelled])


def at_random(eq, seed):
    """A point away from the corners of the laws."""
    drawn = random.Random(seed)
    free = sorted({*eq.used(), *eq.q, *eq.v} - set(eq.definitions), key=str)
    return {x: sp.Float(drawn.uniform(0.5, 1.5)) for x in free}


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(
    "effects",
    [
        {},
        {"backlash": gb.Backlash(half_gap=1e-5), "contact_damping": "always"},
        {"stiffness_variation": gb.Fourier(cos=(0.1,)), "transmission_error": gb.Harmonic(cos=(1e-6,))},
    ],
    ids=["linear", "gap", "variation and error"],
)
def test_the_matrices_are_the_slopes_of_the_forcing(effects, seed):
    eq = mesh_on_a_shaft(**effects).equations()
    found, values = linearized(eq), at_random(eq, seed)
    partials = dict(found.partials)
    while any(e.has(sp.Derivative) for e in partials.values()):
        partials = {d: e.xreplace(partials) for d, e in partials.items()}
    whole = [inserted(e.xreplace(partials), eq.definitions) for e in (*-found.stiffness, *-found.damping)]
    n = len(eq.q)
    jacobian = eq.jacobian()
    wanted = [*jacobian[:, :n], *jacobian[:, n:]]
    np.testing.assert_allclose(numbers(whole, values), numbers(wanted, values), rtol=1e-12, atol=1e-9)
    assert np.any(numbers(wanted, values) != 0.0)


def test_a_gap_has_its_slope_by_a_symbol_of_its_own():
    eq = mesh_on_a_shaft(backlash=gb.Backlash(half_gap=1e-5), contact_damping="always").equations()
    shown = str(eq.linearized())
    assert "∂g_mesh/∂x_mesh = ⎧ 1," in shown
    assert "M Δq'' = -C Δq' - K Δq" in shown
    assert "q = (φ_pinion, φ_wheel, φ_hub)" in shown
    assert shown.count("⎧") == 1


def test_a_contact_whose_damping_comes_from_its_restitution_is_linearised_on_its_side():
    """The side has no slope; it was looked for without end."""
    rig = gb.Drivetrain("throw")
    lash = gb.Lash(k=1e4, half_gap=0.01, contact_damping=gb.HuntCrossley(restitution=0.8))
    rig.chain(rig.add("a", gb.Inertia(J=1.0)), rig.add("lash", lash), rig.add("b", gb.Inertia(J=2.0)))
    found = linearized(rig.equations())
    assert {str(d) for d in found.partials} >= {"Derivative(g_lash, theta_lash)"}
    assert not any(e.has(sp.Derivative) for e in found.partials.values())
    assert "∂g_lash/∂θ_lash" in str(rig.equations().linearized())


@pytest.mark.long
def test_whole_parts_and_cycles_are_linearised_between_their_jumps():
    x = sp.Symbol("x", real=True)
    assert _diff(2 * sp.floor(3 * x) * x + 3 * sp.frac(x), x) == 2 * sp.floor(3 * x) + 3
    assert not _diff(sp.sin(sp.floor(x)) + sp.ceiling(x), x).has(sp.Derivative)
    found = linearized(build(draw("wide", 7043), gb).equations())
    assert not any(e.has(sp.Subs) for e in [*found.stiffness, *found.partials.values()])


def test_a_matrix_stands_in_brackets_where_it_fits_and_by_its_entries_where_it_does_not():
    rig = gb.Drivetrain("rig")
    rig.chain(rig.add("a", gb.Inertia(J=1.0)), rig.add("s", gb.Shaft(k=2.0)), rig.add("b", gb.Inertia(J=1.0)))
    shown = rig.equations().linearized()
    assert "K = ⎡ k_s   -k_s ⎤" in str(shown)
    assert (
        r"K &= \begin{bmatrix} k_{\mathrm{s}} & -k_{\mathrm{s}} \\ -k_{\mathrm{s}} & k_{\mathrm{s}} \end{bmatrix}"
        in shown.latex()
    )
    assert shown.html().count("<mtable>") == 2
    longer = str(mesh_on_a_shaft().equations().linearized())
    assert "K_3,2 = -k_shaft" in longer
    assert "(all other entries are 0)" in longer


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.few(1)
def test_shipped_models_print_their_linearised_equations(name):
    shown = scripts.make(name).equations().linearized()
    lines = str(shown).splitlines()
    assert max(map(len, lines)) <= WIDTH + 4  # numbers of equations may have three digits
    assert "\\begin{align}" in shown.latex()
    assert "<math" in shown.html()


def test_state_matrices_print_their_numbers():
    rig = mesh_on_a_shaft()
    linear = gb.linearize(rig, at=None, inputs=["drive.tau"], outputs=["mesh.force"])
    shown = str(linear.document())
    assert "x' = A x + B u" in shown
    assert f"x: {', '.join(linear.states)}" in shown
    entry = linear.A[np.nonzero(linear.A)][0]
    assert f"{float(f'{entry:.6g}'):g}"[:6] in shown
    assert "\\begin{align}" in linear.latex()
    assert "<math" in linear._repr_html_()
