"""The equations that people read against the C that runs, and against the paper of the spline coupling."""

import sys
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.equations.dependent_groups import DependentGroups
from gearblocks.equations.equations import inserted
from gearblocks.laws.functions import ContactSide, DeadZone
from gearblocks.laws.symbols import time_symbol
from gearblocks.solver.structures import Code, Method, Options
from gearblocks.train.handles import FlangeHandle
from gearblocks.train.values import numbers_of

sys.path.insert(0, str(Path(__file__).parents[3] / "models"))


def _spelled_out(expr):
    """An expression with its dead zones written as Piecewise."""
    expr = expr.replace(lambda e: isinstance(e, DeadZone), lambda e: e.spelled_out())
    return expr.replace(
        lambda e: isinstance(e, ContactSide),
        lambda e: sp.Piecewise((1, e.args[0] > e.args[1]), (-1, e.args[0] < -e.args[1]), (0, True)),
    )


def _train(name):
    rig = gb.Drivetrain(name)
    a, b, c = rig.add("a", gb.Inertia(J=0.7)), rig.add("b", gb.Inertia(J=1.3)), rig.add("c", gb.Inertia(J=2.1))
    control = gb.Input("u", 1.5) * gb.cos(3 * gb.time) + gb.Parameter("P", 0.4) * gb.sense("c.w")
    drive = rig.add("drive", gb.Torque(tau=control))
    mesh = {"teeth": (10, 15), "r_base": (0.8, 1.2), "external": name != "internal", "k": 9.0, "damping_ratio": 0.1}
    if name in ("meshes", "internal"):
        one = rig.add("one", gb.GearMesh(
            **mesh, stiffness_variation=gb.Fourier(cos=(0.2, 0.1), sin=(0.1,)), backlash=gb.Backlash(half_gap=0.3),
            transmission_error=gb.Harmonic(cos=(0.05,), driven_by=2.0), contact_damping="always",
        ))  # fmt: skip
        two = rig.add("two", gb.Lash(k=5.0, half_gap=0.2, c=0.3, contact_damping="clipped"))
        rig.chain(drive, a, one, b, two, c)
        rig.connect(one.carrier, c.b)
    elif name == "teeth":
        shape = {"module": "0.2 m", "pressure_angle": 0.35, "profile_shift": (0.3, 0.1), "helix_angle": 0.2}
        one = rig.add("one", gb.GearMesh(
            teeth=(20, 30), external=True, **shape, face_width=1e-8, stiffness="iso6336", damping_ratio=0.1,
            backlash=gb.Backlash(half_gap=0.2, law="smooth", width=0.1), friction=gb.ToothFriction(mu=0.1, phase=0.2),
        ))  # fmt: skip
        gaps = gb.Backlash(gaps=(0.1, 0.3, 0.2), coast_gaps=(0.2, 0.4, 0.1))
        two = rig.add("two", gb.SplineCoupling(teeth=3, radius=1.3, k=7.0, c=0.3, backlash=gaps))
        fit = gb.Backlash(half_gap=0.4, law="polynomial", degree=7)
        spare = gb.SplineCoupling(teeth=9, radius=0.7, k=2.0, c=0.2, backlash=fit, contact_damping="always")
        rig.chain(drive, a, one, b, two, c)
        rig.chain(c, rig.add("spare", spare), rig.add("wall", gb.Fixed()))
        rub = gb.ToothFriction(mu=0.2, flank="coast", transition=0.3)
        inner = gb.GearMesh(teeth=(20, 73), external=False, module="0.2 m", pressure_angle=0.35, k=3.0, friction=rub)
        rig.chain(a, rig.add("inner", inner), c)
    elif name == "excited":
        one = rig.add("one", gb.GearMesh(
            **mesh, stiffness_variation=gb.Fourier(cos=(0.3,), driven_by=2 + gb.sin(gb.time)),
            transmission_error=gb.Harmonic(sin=(0.05,), phase=0.3), backlash=gb.Backlash(half_gap=0.2),
            contact_damping="clipped_force",
        ))  # fmt: skip
        two = rig.add("two", gb.GearMesh(
            **mesh, stiffness_variation=gb.Square(ripple=0.2, contact_ratio=1.3, driven_by=gb.Parameter("w", 1.7))
        ))  # fmt: skip
        rig.chain(drive, a, one, b, two, c)
    else:
        gear = rig.add("gear", gb.IdealGear(teeth=(10, 23), external=True))
        twist = rig.add("twist", gb.Shaft(torque=4 * gb.twist + sp.Abs(gb.twist) * gb.twist, c=0.2))
        load, damper = rig.add("load", gb.SpeedLoad(coeffs=(0.3, 0.2, 0.1))), rig.add("damper", gb.Damper(c=0.6))
        rig.chain(drive, a, gear, b, twist, c, load)
        rig.connect(damper.a, c.a)
        rig.connect(damper.b, a.a)
        rig.connect(rig.add("ground", gb.Fixed(phi0=0.2)).flange, rig.add("spring", gb.Shaft(k=3.0)).a)
        rig.connect(FlangeHandle(rig, "spring", "b"), c.b)
    return rig


def _by_symbols(rig, model, t, state):
    """Accelerations by name of the angle, and rates of the states of blocks, from the equations for reading."""
    eq = rig.equations()
    forward = {r.path: float(state[f"{r.path.replace('load', 'c')}.w"]) > 0 for r in eq.switched_constraints}
    eq = eq.in_modes({path: 1 if ahead else -1 for path, ahead in forward.items()})
    values = {p.path: v for p, v in zip(model.program.parameters, model.values, strict=True)}
    values |= {i.name: i.start for i in model.program.inputs}
    values |= {f"{c.path}.{field}": x for c in rig.train().components for field, x, _ in numbers_of(c.block, "")}
    known = {symbol: values[path] for symbol, path in eq.parameters.items()}
    known |= {q: state[f"{q.name.removeprefix('phi_')}.phi"] for q in eq.q}
    known |= {v: state[f"{v.name.removeprefix('w_')}.w"] for v in eq.v}
    known |= dict.fromkeys(eq.states, state.get("one.stiffness_variation.angle"))
    known[time_symbol()] = t
    eq = eq.in_modes({rub.path: 1 if _number(rub.sliding, known) > 0 else -1 for rub in eq.switched_constraints})
    forcing = sp.Matrix([_number(e, known) for e in eq.expanded])
    mass = eq.mass_matrix.applyfunc(lambda e: _number(e, known))
    rates = [float(_number(e, known)) for e in eq.states.values()]
    return {v.name.removeprefix("w_"): x for v, x in zip(eq.v, mass.LUsolve(forcing), strict=True)}, rates


def _number(expr, known):
    value = _spelled_out(sp.sympify(expr)).xreplace({x: sp.Float(y, 30) for x, y in known.items()})
    return sp.Float(sp.N(value.replace(sp.Heaviside, lambda x, *_: sp.Integer(1 if x >= 0 else 0)), 30))


@pytest.mark.parametrize(
    "name",
    [*(pytest.param(name, marks=pytest.mark.long) for name in ("meshes", "internal", "teeth", "excited")), "rigid"],
)
def test_the_c_computes_what_the_equations_say(name):
    rig = _train(name)
    model = gb.build(rig)
    program = model.program
    random = np.random.default_rng(7)
    speeds = {q.name: i for i, q in enumerate(program.states)}
    worst = 0.0
    for _ in range(4):
        t = float(random.uniform(0, 3))
        starts = {s.name: float(random.normal(0, 0.5)) for s in program.starts}
        if name == "rigid":  # a and b are tied: 10 teeth to 23
            starts["a.phi"], starts["a.w"] = -2.3 * starts["b.phi"], -2.3 * starts["b.w"]
        with model.library.open() as sim:
            sim.parameters[:] = model.values
            sim.inputs[:] = [i.start for i in program.inputs]
            for s in program.starts:
                sim.parameters[s.offset] = starts[s.name] * s.factor
            assert sim.start(Options(Method.DP8, 1, 1e-6, 0.0, np.inf, np.inf), t) == Code.DONE
            y = sim.state()
            dy = sim.rhs(t, y)
        alpha, rates = _by_symbols(rig, model, t, starts)
        largest = max(abs(float(x)) for x in alpha.values())
        for body, value in alpha.items():
            assert abs(dy[speeds[f"{body}.w"]] - float(value)) <= 1e-12 * largest, (body, t, starts)
            worst = max(worst, abs(float(value)))
        assert [dy[i] for q, i in speeds.items() if q.endswith(".angle")] == pytest.approx(rates, rel=1e-12)
    assert worst > 0.1


# -- the spline coupling ----------------------------------------------------------------------------------------------


def _spline():
    import spline_coupling

    eq = spline_coupling.build().equations()
    s = {path: symbol for symbol, path in eq.parameters.items()}
    names = ("input", "external", "internal", "output")
    return eq, s, names


def _paper(s, names):
    """Symbols of the paper by those of the train: inertias, stiffnesses, damping, torque."""
    I = [s[f"{n}.J"] for n in names]  # noqa: E741
    k1, k4, r = s["shaft_in.k"], s["shaft_out.k"], s["radius"]
    c1 = 2 * s["shaft_in.damping_ratio"] * sp.sqrt(k1 / (1 / I[0] + 1 / I[1]))
    c4 = 2 * s["shaft_out.damping_ratio"] * sp.sqrt(k4 / (1 / I[2] + 1 / I[3]))
    km, t = s["spline.k"], time_symbol()
    kt = km * (1 + s["spline.stiffness_variation.cos[0]"] * sp.cos(s["speed"] * t))
    ct = 2 * s["spline.damping_ratio"] * sp.sqrt(km / (1 / (I[1] / r**2) + 1 / (I[2] / r**2)))
    T = s["torque"] * (1 + s["torque_variation"] * sp.cos(s["speed"] * t))
    return I, k1, k4, r, c1, c4, kt, ct, T


def _same(one, other):
    """Whether two expressions agree at random points (dead zones spelled out), to 25 digits."""
    difference = _spelled_out(sp.sympify(one)) - _spelled_out(sp.sympify(other))
    symbols = sorted(difference.free_symbols, key=str)
    random = np.random.default_rng(3)
    for _ in range(5):
        point = {x: sp.Rational(int(random.integers(1, 999)), 500) for x in symbols}
        size = 1 + abs(sp.N(_spelled_out(sp.sympify(other)).subs(point), 40))
        if abs(sp.N(difference.subs(point), 40)) > sp.Float("1e-25") * size:
            return False
    return True


@pytest.mark.long
def test_the_angle_form_of_the_spline_coupling_is_the_papers():
    eq, s, names = _spline()
    I, k1, k4, r, c1, c4, kt, ct, T = _paper(s, names)  # noqa: E741
    th, w = eq.q, eq.v
    N = ct * r * (w[1] - w[2]) + kt * DeadZone(r * (th[1] - th[2]), s["spline.backlash.half_gap"], 0)
    one = c1 * (w[0] - w[1]) + k1 * (th[0] - th[1])
    four = c4 * (w[2] - w[3]) + k4 * (th[2] - th[3])
    right = (T - one, one - r * N, r * N - four, four - T)
    assert eq.mass_matrix == sp.diag(*I)
    for ours, papers in zip(eq.expanded, right, strict=True):
        assert _same(ours, papers)
    # the mesh force keeps its name in the equations, and stands in those of both splines alone
    (force,) = [x for x in eq.definitions if str(x) == "N_spline"]
    assert [e.has(force) for e in eq.forcing] == [False, True, True, False]


@pytest.mark.long
def test_the_relative_form_of_the_spline_coupling_is_the_papers_term_by_term():
    eq, s, names = _spline()
    I, k1, k4, r, c1, c4, kt, ct, T = _paper(s, names)  # noqa: E741
    x = list(eq.coordinates)
    assert [str(c) for c in x] == ["x1", "x2", "x3"]
    v = [sp.Symbol(f"x{i}'", real=True) for i in (1, 2, 3)]
    N = next(y for y in eq.definitions if str(y) == "N_spline")
    papers = (
        r * T / I[0] - (1 / I[0] + 1 / I[1]) * (c1 * v[0] + k1 * x[0]) + r**2 / I[1] * N,
        (c1 * v[0] + k1 * x[0]) / I[1] + (c4 * v[2] + k4 * x[2]) / I[2] - (r**2 / I[1] + r**2 / I[2]) * N,
        r * T / I[3] - (1 / I[2] + 1 / I[3]) * (c4 * v[2] + k4 * x[2]) + r**2 / I[2] * N,
    )
    relative = eq.relative_form()
    assert [str(e.lhs) for e in relative] == ["x1''", "x2''", "x3''"]
    constants = {e.lhs: e.rhs for e in eq.relative_definitions() if e.lhs != N}
    for equation, paper in zip(relative, papers, strict=True):
        ours = sp.Eq(equation.lhs, inserted(equation.rhs, constants), evaluate=False)
        for term in (*x, *v, N):  # each coefficient by itself
            assert _same(sp.diff(ours.rhs, term), sp.diff(paper, term)), (ours.lhs, term)
        assert _same(ours.rhs, paper)
        assert not ours.rhs.free_symbols & {*eq.q, *eq.v}
    definitions = {str(e.lhs): e.rhs for e in eq.relative_definitions()}
    kt_symbol = next((y for y in eq.definitions if str(y).startswith("k_t")), None)
    force = definitions["N_spline"]
    force = inserted(force, constants)
    assert kt_symbol is not None
    assert _same(force, ct * v[1] + kt * DeadZone(x[1], s["spline.backlash.half_gap"], 0))


def test_effects_with_fields_of_one_name_keep_their_own_symbols():
    eq = _train("meshes").equations()
    paths = list(eq.parameters.values())
    assert len(paths) == len(set(paths)) == len(eq.parameters)
    assert {"one.stiffness_variation.cos[0]", "one.transmission_error.cos[0]"} <= set(paths)


def test_a_relative_form_is_shown_only_where_it_is_closed():
    assert _train("meshes").equations().relative_form() == []  # an error driven by time moves the deflection by itself


def test_the_equations_print_in_every_form():
    eq, _, _ = _spline()
    text, latex = str(eq), eq.latex()
    for word in ("x1''", "x2''", "x3''", "N_spline"):
        assert word in text
    assert latex.count(r"\begin{align}") == latex.count(r"\end{align}") >= 4
    assert r"\ddot{x}" in latex
    assert r"\cos" in latex
    assert eq._repr_latex_().startswith(r"\begin{align*}")
    assert eq.html().count("<math") == eq.html().count("</math>") > 30
    assert eq.mathml().count("<math") > 20
    assert eq.jacobian().shape == (4, 8)


def test_the_inertia_of_coupled_shafts_is_written_only_where_a_damping_ratio_asks_for_it(monkeypatch):
    """Ten shafts behind a joint took minutes: the mass matrix was inverted in symbols for each of them."""

    def row(**damping):
        rig = gb.Drivetrain("coupled")
        engine = [rig.add("engine", gb.Inertia(J=1.0)), rig.add("joint", gb.UniversalJoint(angle=0.3))]
        rest = [rig.add("shaft", gb.Shaft(k=9.0, **damping)), rig.add("load", gb.Inertia(J=2.0))]
        rig.chain(*engine, rig.add("axle", gb.Inertia(J=1.0)), *rest)
        return rig

    asked = []
    inertia = DependentGroups.inertia
    monkeypatch.setattr(DependentGroups, "inertia", lambda *args: asked.append(args[2]) or inertia(*args))
    row(c=0.1).equations()
    assert asked == []
    assert "J_e_shaft" in {str(s) for s in row(damping_ratio=0.1).equations().definitions}
    assert len(asked) == 2


def test_a_sensed_speed_that_follows_from_others_is_written_over_these():
    """The middle of the gears has no body: its speed stood in the balance by a symbol that nothing explained."""
    rig = gb.Drivetrain("sensed")
    one, two = rig.add("one", gb.IdealGear(ratio=2)), rig.add("two", gb.IdealGear(ratio=3))
    drive = rig.add("drive", gb.Torque(tau=-4 * gb.sense("one.b.w")))
    rig.chain(drive, rig.add("motor", gb.Inertia(J=1.0)), one, two, rig.add("load", gb.Inertia(J=9.0)))
    eq = rig.equations()
    (torque,) = eq.expanded
    assert torque.free_symbols == {*eq.v}
    assert "one_b" not in str(eq)


def test_a_train_in_which_no_shaft_moves_by_itself_has_a_jacobian_without_rows():
    rig = gb.Drivetrain("clamped")
    rig.chain(rig.add("left", gb.Fixed()), rig.add("shaft", gb.Shaft(k=1.0)), rig.add("right", gb.Fixed()))
    assert rig.equations().jacobian().shape == (0, 0)
