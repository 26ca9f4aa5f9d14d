"""From printed LaTeX back to numbers, for every shipped model and mode: they are those of the C that runs."""

import functools

import mpmath as mp
import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PPoly

import gearblocks as gb
from gearblocks.cli import scripts
from gearblocks.equations.latex import name_latex
from gearblocks.equations.lexicon import flat
from gearblocks.equations.names import owners
from gearblocks.geometry.ratio_curves import Pieces
from gearblocks.language.tables import Table2
from gearblocks.solver.structures import Code, Method, Options
from gearblocks.solver.switched_constraints import ConstraintKind
from gearblocks.train.values import numbers_of
from tests.unit.equations.latex_reader import Moving, Sheet, UnknownError, bare, of_all, read
from tests.unit.equations.planets import planets

MODELS = [f"{name}:{maker.name}" for name in scripts.shipped() for maker in scripts.makers(scripts.locate(name)[0])]
QUICK = ("spline_coupling:build",)


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(30):
        yield


# -- tables, by scipy -------------------------------------------------------------------------------------------------


def _of_table(table):
    """A function of (arguments, primes) for a table of the nomenclature."""
    if isinstance(table, Table2):
        return functools.partial(_over_two, table)
    if isinstance(table, Pieces):
        return functools.partial(_of_pieces, table)
    if table.kind == "cubic":
        ends = "periodic" if table.periodic else "clamped" if table.ends == "flat" else "not-a-knot"
        curve = CubicSpline(table.x, table.y, bc_type=ends)
    else:
        slope = np.diff(table.y) / np.diff(table.x) * (table.kind == "linear")
        curve = PPoly([slope, table.y[:-1]], table.x)
    return functools.partial(_of_curve, table, curve)


def _of_curve(table, curve, arguments, primes):
    (x,) = arguments
    at, low, high = float(x.value), table.x[0], table.x[-1]
    inside = low <= at < high or table.periodic
    at = low + np.mod(at - low, high - low) if table.periodic else min(max(at, low), high)
    last = at >= high and table.kind == "step"
    values = [table.y[-1] if last else curve(at, nu=k) if inside or k == 0 else 0.0 for k in (primes, primes + 1)]
    return x.through(mp.mpf(float(values[0])), mp.mpf(float(values[1])))


def _of_pieces(table, arguments, primes):
    (x,) = arguments
    value, slope = (mp.mpf(float(table.value(float(x.value), order))) for order in (primes, primes + 1))
    return x.through(value, slope)


def _over_two(table, arguments, primes):
    assert not primes and table.kind == "linear"
    places = []
    for points, at in zip((table.x, table.y), arguments, strict=True):
        at = min(max(float(at.value), points[0]), points[-1])
        i = min(int(np.searchsorted(points, at, side="right")) - 1, len(points) - 2)
        places.append((i, (at - points[i]) / (points[i + 1] - points[i])))
    (i, a), (k, b) = places
    z = np.asarray(table.z)
    value = (1 - a) * ((1 - b) * z[i, k] + b * z[i, k + 1]) + a * ((1 - b) * z[i + 1, k] + b * z[i + 1, k + 1])
    return Moving(mp.mpf(float(value)), None)


# -- the C at a point -------------------------------------------------------------------------------------------------


def _flat(output):
    """The name of an output, its part as symbols have it: gear_planet1.phi for gear.planet[1].phi."""
    path, _, name = output.rpartition(".")
    return f"{flat(path)}.{name}"


def _point(model, random):
    """Time, states, modes by path and outputs by name (see _flat) at random states, modes drawn at random."""
    program = model.program
    t = float(random.uniform(0, 3))
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        sim.inputs[:] = [i.start for i in program.inputs]
        for s in program.starts:
            value = random.normal(0, 30.0 if s.name.endswith((".w", ".v")) else 0.5)
            sim.parameters[s.offset] = value * s.factor
        options = Options(Method.DP8, 1, 1e-6, 0.0, np.inf, np.inf)
        if sim.start(options, t) != Code.DONE:  # lossy gears turn along: from their own start values
            sim.parameters[:] = model.values
            assert sim.start(options, t) == Code.DONE
        y, switches = sim.state(), sim.modes()
        drawn = []
        for kind, slip, active, free in sim.constraints().constraints:
            allowed = {ConstraintKind.STOP: (0, 1), ConstraintKind.TIE: (1, -1), ConstraintKind.LOSS: (0, 1, -1)}
            modes = allowed.get(kind, (0, 1, -1) if free < 0 else (0, 1, -1, 2))
            mode = int(random.choice(modes))
            drawn.append(mode)
            held = mode == (1 if kind is ConstraintKind.STOP else 0) or kind is ConstraintKind.TIE
            switches[active] = held
            switches[slip] = mode if mode in (1, -1) and kind is not ConstraintKind.STOP else 0
            if free >= 0:
                switches[free] = mode == 2
        shown = sim.probe(t, y, switches, "outputs")
    names = [x.name for x in program.states]
    outputs = {_flat(o.name): float(x) for o, x in zip(program.outputs, shown, strict=True)}
    return t, dict(zip(names, y, strict=False)), drawn, outputs


# -- the paper --------------------------------------------------------------------------------------------------------


def _known(rig, model, eq, t, states, outputs):
    """Numbers of what the equations do not say: angles, speeds, states, parameters and inputs."""
    program = model.program
    values = {p.path: v for p, v in zip(program.parameters, model.values, strict=True)}
    values |= {i.name: i.start for i in program.inputs}
    values |= {f"{c.path}.{field}": x for c in rig.train().components for field, x, _ in numbers_of(c.block, "")}
    known = {("t", 0): Moving(mp.mpf(t), mp.mpf(1))}

    def number(symbol):
        return bare(name_latex(eq.names[symbol]))

    for symbol, path in eq.parameters.items():
        if isinstance(values.get(path), (int, float)):
            known[number(symbol)] = Moving(mp.mpf(float(values[path])))
    for q in eq.q:
        body = q.name.split("_", 1)[1]
        phi, w = (".s", ".v") if f"{body}.v" in outputs else (".phi", ".w")
        known[number(q)] = Moving(mp.mpf(outputs[body + phi]), mp.mpf(outputs[body + w]))
    for symbol in eq.states:
        path = eq.entries[symbol].path or f"{symbol.name.removeprefix('phi_').replace('_', '.')}.phi"
        found = next(p for p in (path, f"{path}.phi") if p in states)
        known[number(symbol)] = Moving(mp.mpf(states[found]), None)
    return known


def _written(equations, known, tables):
    """Every symbol that the equations define. Rates of states are found first: what moves with them needs those."""
    plain = [x for x in equations if r"\ddot" not in x[1] and not x[0].startswith(("Relative form", "Functions"))]
    first = Sheet(dict(known), tables)
    _entered(first, plain)
    rates = {(name, 0): x.value for (name, dots), x in first.known.items() if dots == 1}
    sheet = Sheet({n: Moving(x.value, rates.get(n)) if x.rate is None else x for n, x in known.items()}, tables)
    assert not _entered(sheet, plain)
    return sheet


def _entered(sheet, waiting):
    """Enters what can be computed, as often as something new is known; returns what cannot be."""
    while waiting:
        later = [x for x in waiting if not _is_entered(sheet, *x[1:])]
        if len(later) == len(waiting):
            break
        waiting = later
    return waiting


def _is_entered(sheet, left, right):
    name = bare(left)
    try:
        value = sheet.value(right)
    except UnknownError:
        return False
    before = sheet.known.setdefault(name, value)
    assert abs(before.value - value.value) <= 1e-20 * (1 + abs(value.value)), left
    return True


def _accelerations(eq, equations, sheet):
    """The balances solved: they are linear in the accelerations."""
    rows = [
        (left, right) for heading, left, right in equations if heading.startswith("Angle form") and r"\ddot" in left
    ]
    names = [(bare(name_latex(eq.names[q]))[0], 2) for q in eq.q]
    if not names:
        return []

    def residual(alpha):
        sheet.known |= {name: Moving(mp.mpf(a), None) for name, a in zip(names, alpha, strict=True)}
        return mp.matrix([sheet.value(left).value - sheet.value(right).value for left, right in rows])

    n = len(names)
    none = residual([0] * n)
    mass = mp.matrix(n, n)
    for k in range(n):
        mass[:, k] = residual([int(i == k) for i in range(n)]) - none
    found = mp.lu_solve(mass, -none)
    residual(found)
    return found


def _relative(eq, equations, sheet, alpha):
    """(printed, expected) accelerations of the relative coordinates; these are linear in the angles."""
    shown = {bare(left)[0]: right for heading, left, right in equations if heading.startswith("Relative coordinates")}
    numbers = [bare(name_latex(eq.names[q])) for q in eq.q]
    speeds = {n: Moving(sheet.known[n].rate, a) for n, a in zip(numbers, alpha, strict=True)}
    faster = Sheet({**sheet.known, **speeds}, sheet.tables)
    for heading, left, right in equations:
        if heading.startswith("Relative form"):
            yield sheet.value(right).value, faster.value(shown[bare(left)[0]]).rate


def _checked(rig, places):
    """Compares paper and C at random points, `places` of them, modes drawn at random; how many rows of a relative form."""
    model, eq = gb.build(rig), rig.equations()
    random = np.random.default_rng(11)
    tables = {
        name_latex(eq.names[s]): _of_table(entry.table) for s, entry in eq.entries.items() if entry.table is not None
    }
    tables = {bare(latex)[0]: function for latex, function in tables.items()}
    moved, relative = False, 0
    for _ in range(places):
        t, states, drawn, outputs = _point(model, random)
        modes = {c.path: mode for c, mode in zip(eq.switched_constraints, drawn, strict=True)}
        found = eq.in_modes(modes)
        equations = [*of_all(read(found.latex()), owners(eq.kinds).values())]
        known = _known(rig, model, found, t, states, outputs)
        constants = [(n, e.value) for n, e in found.document().nomenclature.entries if e.words == "constant"]
        known |= {bare(name_latex(name)): Moving(mp.mpf(value)) for name, value in constants}
        sheet = _written(equations, known, tables)
        alpha = _accelerations(found, equations, sheet)
        largest = max((abs(x) for x in alpha), default=0)
        moved |= largest > 1e-3
        for q, a in zip(eq.q, alpha, strict=True):
            body = q.name.split("_", 1)[1]
            c = outputs[f"{body}.acceleration" if f"{body}.v" in outputs else f"{body}.alpha"]
            assert abs(c - a) <= 1e-12 * (1 + largest), (modes, body, c, float(a))
        for symbol in found.ties:
            body = symbol.name.split("_", 1)[1]
            angle = outputs[f"{body}.phi" if f"{body}.phi" in outputs else f"{body}.s"]
            assert abs(sheet.known[bare(name_latex(eq.names[symbol]))].value - angle) <= 1e-12 * (1 + abs(angle)), body
        for printed, expected in _relative(found, equations, sheet, alpha):
            assert abs(printed - expected) <= 1e-20 * (1 + abs(expected))
            relative += 1
    assert moved or not eq.q  # states alone: reference/test_noncircular_planetary.py compares those term by term
    return relative


@pytest.mark.parametrize("name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.long) for n in MODELS])
def test_what_stands_on_paper_is_what_runs(name):
    rig = scripts.make(name)
    relative = _checked(rig, 12 if rig.equations().switched_constraints else 2)
    assert relative >= (6 if name.startswith("spline_coupling") else 0)


# -- what no shipped model has ----------------------------------------------------------------------------------------


def _joints(rig):
    """Two joints in a row, a brake between them: gains of gains, and a slip that is one of them times a speed."""
    middle = rig.add("middle", gb.Inertia(J=0.3))
    one, two = gb.UniversalJoint(angle="20 deg"), gb.UniversalJoint(angle="35 deg", phase=0.3)
    yield from (rig.add("one", one), middle, rig.add("two", two))
    rig.connect(rig.add("brake", gb.Brake(capacity=1.5)).a, middle.b)


def _swung(rig):
    """A rigid non-circular pair whose phase moves in time."""
    law = gb.RatioLaw.ellipse(e=0.3)
    yield rig.add("pair", gb.NonCircularGear(law=law, external=True, phase=0.2 * gb.sin(3 * gb.time)))


def _slanted(rig):
    """Shifted helical teeth with the stiffness of the standard, and friction on their lever arms."""
    yield rig.add(
        "mesh",
        gb.GearMesh(
            teeth=(23, 73), external=False, module="0.2 m", pressure_angle="20 deg", helix_angle=0.2, face_width=1e-8,
            stiffness="iso6336", profile_shift=(0.3, 0.1), addendum=0.9, damping_ratio=0.05,
            backlash=gb.Backlash(half_gap=0.1), friction=gb.ToothFriction(mu=0.06, transition=0.1),
        ),
    )  # fmt: skip


def _losses(rig):
    """A gear whose efficiencies and bearing torques are tables over its speed."""
    rows = ((0.0, 0.9, 0.8, 0.1, 0.2), (5.0, 0.95, 0.9, 0.2, 0.3), (40.0, 0.97, 0.85, 0.5, 0.4))
    yield rig.add("gear", gb.LossyGear(ratio=2.0, loss_table=rows))


def _measured(rig):
    """A mesh whose stiffness and errors are tables, each another one, driven at once by the teeth and by a table of its own."""
    stiffness, run_out = (gb.Table([0.0, 0.3, 1.0], [a, -a / 2, a], "cubic", periodic=True) for a in (0.2, 0.05))
    errors = (
        gb.Profile(table=gb.Table([0.0, 0.6, 1.0], [0.1, -0.1, 0.1], periodic=True)),
        gb.Profile(table=run_out, driven_by=gb.Table([0.0, 2.0], [3.0, 5.0])),
    )
    yield rig.add(
        "mesh",
        gb.GearMesh(
            teeth=(10, 15), external=True, r_base=(0.8, 1.2), k=9.0, damping_ratio=0.1,
            stiffness_variation=gb.Profile(table=stiffness), transmission_error=errors,
        ),
    )  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize(
    "parts", [_joints, _measured, *(pytest.param(x, marks=pytest.mark.long) for x in (_swung, _slanted, _losses))]
)
def test_what_stands_on_paper_of_gains_and_of_teeth_is_what_runs(parts):
    rig = gb.Drivetrain("train")
    motor, load = rig.add("motor", gb.Inertia(J=0.1)), rig.add("load", gb.Inertia(J=0.2))
    drive, brake = rig.add("drive", gb.Torque(tau=3.0)), rig.add("lag", gb.Torque(tau=gb.sin(gb.time)))
    rig.chain(drive, motor, *parts(rig), load, brake)
    _checked(rig, 4)
    written = max(len(text) for equation in read(rig.equations().latex()) for text in equation)
    assert written < 1000, "gains or teeth are written out"


@pytest.mark.parametrize("kind", ["waves", "tables", "errors"])
@pytest.mark.few(1)
def test_what_stands_on_paper_of_phases_and_slopes_is_what_runs(kind):
    _checked(planets(kind), 2)
