"""Friction, locks and stops in the equations that people read, against the C that runs."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.cli import scripts
from gearblocks.laws.symbols import time_symbol
from gearblocks.solver.structures import Options
from gearblocks.train.values import numbers_of


class Disc(gb.Block):
    """Friction between a and b (or the housing) that grows with the slip while it slides."""

    a, b = gb.Flange("one side"), gb.Flange("other side", ground=True)
    capacity = gb.signal("friction torque at rest", "N m")
    viscous = gb.param("growth with the slip", "N m s/rad", default=0.3)

    def physics(self, s):
        slip = s.b.w - s.a.w
        yield gb.Stick("", slip, 1.5 * s.capacity, sliding=s.capacity + s.viscous * sp.Abs(slip), engaged=s.capacity)
        direction, stuck, held = s.stick("")
        yield gb.Shows("torque", held - direction * (s.capacity + s.viscous * sp.Abs(slip)), "N m")
        yield gb.Shows("mode", direction + 2 * (1 - direction**2) * (1 - stuck), "1")


class Wall(gb.Block):
    """A stop between a and b: phi_b - phi_a >= -play."""

    a, b = gb.Flange("one side"), gb.Flange("other side", ground=True)
    play = gb.param("free angle", "rad")
    e = gb.param("restitution", "1", default=0.5)
    impulse, impacts = gb.State("last impulse", "N m s"), gb.State("impacts so far", "1")

    def physics(self, s):
        yield gb.Stop("", s.b.phi - s.a.phi + s.play, s.e, s.impulse, s.impacts)
        yield gb.Shows("torque", s.stick("")[2], "N m")


def _train():
    """Two gears and three discs in a row, two clutches that bridge one another, a brake and a stop."""
    rig = gb.Drivetrain("friction")
    one, two, three = (rig.add(n, gb.Inertia(J=J)) for n, J in (("one", 0.7), ("two", 1.3), ("three", 2.1)))
    gear = rig.add("gear", gb.IdealGear(teeth=(10, 23), external=True))
    four = rig.add("four", gb.Inertia(J=0.4))
    near, far = rig.add("near", Disc(capacity=30.0)), rig.add("far", Disc(capacity=40.0 + 5.0 * gb.sin(gb.time)))
    brake, wall = rig.add("brake", Disc(capacity=20.0)), rig.add("wall", Wall(play=0.4))
    rig.chain(rig.add("drive", gb.Torque(tau=3.0)), one, rig.add("shaft", gb.Shaft(k=50.0, c=0.2)), two)
    rig.connect(two.b, near.a, far.a, wall.a)
    rig.connect(near.b, far.b, three.a, wall.b)
    rig.chain(three, gear, four)
    rig.connect(brake.a, four.b)
    return rig


def _known(rig, model, t, state):
    """Numbers for the symbols of the equations."""
    eq = rig.equations()
    values = {p.path: v for p, v in zip(model.program.parameters, model.values, strict=True)}
    values |= {f"{c.path}.{field}": x for c in rig.train().components for field, x, _ in numbers_of(c.block, "")}
    known = {symbol: values[path] for symbol, path in eq.parameters.items()}
    known |= {q: state[f"{q.name.removeprefix('phi_')}.phi"] for q in eq.q}
    known |= {v: state[f"{v.name.removeprefix('w_')}.w"] for v in eq.v}
    return eq, known | {time_symbol(): t}


def _switches_of(program, name):
    """Numbers of the switches of a component: of its slip or gap, and whether it is active."""
    return [i for i, s in enumerate(program.switches) if s.component == name][:2]


MODES = [
    {"near": 1, "far": 1, "brake": -1, "wall": 0}, {"near": 2, "far": -1, "brake": 1, "wall": 0},
    {"near": 0, "far": 2, "brake": 1, "wall": 0}, {"near": 0, "far": 2, "brake": 0, "wall": 0},
    {"near": 2, "far": 1, "brake": 2, "wall": 1}, {"near": 0, "far": 2, "brake": -1, "wall": 1},
    {"near": 0, "far": 0, "brake": 2, "wall": 1},
]  # fmt: skip


@pytest.mark.parametrize("modes", MODES, ids=str)
@pytest.mark.few(1)
def test_the_c_computes_what_the_equations_say_in_every_mode(modes):
    rig = _train()
    model = gb.build(rig)
    program, random = model.program, np.random.default_rng(5)
    speeds = {q.name: i for i, q in enumerate(program.states)}
    outputs = {q.name: i for i, q in enumerate(program.outputs)}
    t = float(random.uniform(0, 3))
    state = {
        f"{body}.{what}": float(random.normal(0, 0.5)) for body in ("one", "two", "three") for what in ("phi", "w")
    }
    state |= {"wall.slip": 0.0}
    eq, known = _known(rig, model, t, state)
    found = eq.in_modes(modes)
    forcing = sp.Matrix([sp.N(e.xreplace(known), 30) for e in found.expanded])
    alpha = found.mass_matrix.xreplace(known).LUsolve(forcing)
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        for s in program.starts:
            if s.name in state:
                sim.parameters[s.offset] = state[s.name] * s.factor
        sim.start(Options(2, 1, 1e-6, 0.0, np.inf, np.inf), t)
        y = sim.state()
        for v in eq.v:  # an impact at the start may have changed them
            y[speeds[f"{v.name.removeprefix('w_')}.w"]] = known[v]
        switches = np.zeros(len(program.switches))
        for name, mode in modes.items():
            slip, active = _switches_of(program, name)
            held = mode == (1 if name == "wall" else 0)
            switches[slip], switches[active] = 0 if held or mode in (0, 2) or name == "wall" else mode, held
        dy = sim.probe(t, y, switches, "rates")
        shown = sim.probe(t, y, switches, "outputs")
    largest = max(abs(float(x)) for x in alpha)
    assert largest > 0.1
    for v, x in zip(eq.v, alpha, strict=True):
        assert abs(dy[speeds[v.name[2:] + ".w"]] - float(x)) <= 1e-12 * largest, v  # rounding of sums of a few torques
    if [modes["near"], modes["far"], 1 - modes["wall"]].count(0) > 1:
        return  # they share a load: the motion is what counts
    for rub in eq.switched_constraints:
        torque = found.definitions[rub.torque]
        while set(torque.free_symbols) & set(found.definitions):
            torque = torque.xreplace(dict(found.definitions))
        torque = float(torque.xreplace(known))
        assert abs(shown[outputs[f"{rub.path}.torque"]] - torque) <= 1e-12 * (100 + abs(torque)), rub.path


def test_friction_is_written_as_a_torque_with_its_cases():
    eq = _train().equations()
    text = str(eq)
    assert "J_one φ_one'' = " in text
    assert "J_two φ_two'' = -T_near - T_far - T_wall - T_shaft" in text
    for line in (
        "Δω_near = φ_three' - φ_two'",
        "slides forward, Δω_near > 0: T_near = -viscous_near Δω_near - C_near",
        "slides backward, Δω_near < 0: T_near = C_near - viscous_near Δω_near",
        "sticks, Δω_near = 0: Δω_near' = 0 determines T_near, |T_near| <= 1.5 C_near",
        "free, C_near <= 0: T_near = 0",
        "open, φ_three - φ_two + play_wall > 0: T_wall = 0",
        "impact as the gap closes: Δω_wall becomes -e_wall Δω_wall",
    ):
        assert line in text, line
    assert "sticks, $" in eq.latex()
    assert "<mtext>sticks,\xa0</mtext>" in eq.html()


def test_what_a_law_reads_of_friction_is_explained():
    rig = gb.Drivetrain("read")
    one, two = rig.add("one", gb.Inertia(J=2.0)), rig.add("two", gb.Inertia(J=3.0))
    rig.chain(one, rig.add("clutch", gb.Clutch(capacity=5.0)), two)
    rig.chain(two, rig.add("drive", gb.Torque(tau=gb.sense("clutch.mode"))))
    text = str(rig.equations())
    assert "s_clutch: 1 while stuck, else 0" in text
    assert "φ_clutch" not in text  # the relative angle moves nothing


@pytest.mark.long
def test_the_losses_of_a_gear_are_written_by_direction_of_the_power_and_are_those_of_the_c():
    rig = gb.Drivetrain("lossy")
    one, two = rig.add("one", gb.Inertia(J=1.0, w0=2.0)), rig.add("two", gb.Inertia(J=3.0, w0=1.0))
    gear = rig.add("gear", gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.8), bearing=(0.1, 0.2)))
    rig.chain(rig.add("drive", gb.Torque(tau=10.0)), one, gear, two, rig.add("load", gb.Torque(tau=-5.0)))
    eq = rig.equations()
    assert "drives, φ_one' > 0 and T_gear_tie + T_b1_gear >= 0: T_gear_loss" in str(eq)
    values = {f"{c.path}.{field}": x for c in rig.train().components for field, x, _ in numbers_of(c.block, "")}
    known = {s: values[p] for s, p in eq.parameters.items()}
    found = eq.in_modes({"gear.tie": 1, "gear.loss": 1})
    alpha = [
        float(f.xreplace(known) / J.xreplace(known))
        for f, J in zip(found.expanded, eq.mass_matrix.diagonal(), strict=True)
    ]
    run = gb.simulate(rig, t_end=0.1)
    assert alpha == pytest.approx([run["one.alpha"][0], run["two.alpha"][0]], rel=1e-12)
    with pytest.raises(gb.ParameterError, match=r"'gear\.loss' and 'gear\.tie' belong together"):
        eq.in_modes({"gear.loss": 1})


def test_the_torque_that_holds_two_stuck_discs_together_is_that_of_the_textbook():
    rig = gb.Drivetrain("pair")
    one, two = rig.add("one", gb.Inertia(J=2.0)), rig.add("two", gb.Inertia(J=3.0))
    clutch = rig.add("clutch", Disc(capacity=50.0))
    rig.chain(rig.add("drive", gb.Torque(tau=10.0)), one)
    rig.connect(one.b, clutch.a)
    rig.connect(clutch.b, two.a)
    eq = rig.equations().in_modes({"clutch": 0})
    J1, J2, tau = sp.symbols("J_one J_two tau_drive", real=True)
    (held,) = [e for x, e in eq.definitions.items() if str(x) == "T_clutch"]
    assert sp.simplify(held - tau * J2 / (J1 + J2)) == 0
    assert [sp.simplify(a / J - tau / (J1 + J2)) for a, J in zip(eq.expanded, (J1, J2), strict=True)] == [0, 0]


@pytest.mark.long
def test_the_torque_of_what_is_stuck_stays_short():
    """By the named torques beside it, and ratios as fractions: it was one expression of numbers with fifteen digits."""
    text = str(scripts.make("dual_clutch").equations().in_modes({"K1": 0, "K2": 1, "hill_hold": 2}))
    assert "(25 J_output + 4624 J_shaft1 + 1681 J_shaft2)" in text
    assert "5 T_half_shafts + 41 T_K2" in text
    assert "φ_K1" not in text  # it moves nothing
    tied = scripts.make("modelica_examples:lossy_gear").equations().in_modes({"gear.tie": 1, "gear.loss": 0})
    assert "T_gear_tie = (10 - 2.5 t)/i_gear " in str(tied)
    assert "10 sin(2 π t)" in str(tied)


def test_a_coordinate_is_the_angle_of_the_body_that_it_is_called_after():
    """It was that of the shaft which the assembly happened to count in."""
    rig = gb.Drivetrain("geared")
    fast, slow = rig.add("fast", gb.Inertia(J=2.0)), rig.add("slow", gb.Inertia(J=1.0))
    rig.chain(rig.add("drive", gb.Torque(tau=1.0)), fast, rig.add("gear", gb.IdealGear(ratio=3.0)), slow)
    eq = rig.equations()
    (q,) = eq.q
    gains = {q: 1, **{s: sp.diff(e, q) for s, e in eq.ties.items()}}
    assert {s.name: 1 / gain for s, gain in gains.items()} in (
        {"phi_fast": 1, "phi_slow": 3},
        {"phi_slow": 1, "phi_fast": sp.Rational(1, 3)},
    )
    squares = {f"J_{s.name.removeprefix('phi_')}": gain**2 for s, gain in gains.items()}
    assert {x.name: sp.diff(eq.mass_matrix[0], x) for x in eq.mass_matrix.free_symbols} == squares


def test_modes_that_nothing_has_are_refused_by_name():
    eq = _train().equations()
    with pytest.raises(gb.ParameterError, match="no friction or stop is named 'nera' - did you mean 'near'"):
        eq.in_modes({"nera": 0})
    with pytest.raises(gb.ParameterError, match="'wall' = 2 must be one of: 1 closed, 0 open"):
        eq.in_modes({"wall": 2})


@pytest.mark.long
@pytest.mark.parametrize("mode", [0, 1, -1])
def test_the_inner_friction_of_a_shaft_acts_in_print_as_it_does_in_the_c(mode):
    """Its slip is the rate of the twist, which has a name of its own: the torque was missing in the balances."""
    rig = gb.Drivetrain("inner friction")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=2.0, w0=3.0 * mode))
    shaft = rig.add("shaft", gb.Shaft(k=20.0, c=0.1, hysteresis=gb.Hysteresis(friction=1.5)))
    rig.chain(rig.add("drive", gb.Torque(tau=0.6)), one, shaft, two)
    eq = rig.equations()
    assert "J_one φ_one'' = T_shaft - T_shaft_hysteresis + τ_drive" in str(eq)
    values = {f"{c.path}.{field}": x for c in rig.train().components for field, x, _ in numbers_of(c.block, "")}
    known = {s: values[p] for s, p in eq.parameters.items()} | dict.fromkeys(eq.q, 0.0)
    known |= dict(zip(eq.v, (0.0, 3.0 * mode), strict=True))
    found = eq.in_modes({"shaft.hysteresis": mode})
    alpha = [float(f.xreplace(known)) / J for f, J in zip(found.expanded, (1.0, 2.0), strict=True)]
    run = gb.simulate(rig, t_end=1e-3)
    assert alpha == pytest.approx([run["one.alpha"][0], run["two.alpha"][0]], rel=1e-12)
    assert alpha[1] == pytest.approx({0: 0.2, 1: -0.9, -1: 0.9}[mode])
