"""What holds for every train: random trees and loops of inertias, shafts, dampers, gaps, meshes and ideal gears.

Examples are drawn anew from the same seed in every run. Numbers are coarse and of the order of 1 (J, w t), so that a
train turns and hits some tens of times within the second that is simulated.
"""

import math
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import gearblocks as gb
from gearblocks.solver.structures import Code, Method, Options

GROUND = -1
T = np.linspace(0.0, 1.0, 21)
TIGHT = {"t": T, "rtol": 1e-11, "method": "dp8"}
NEAR = 1e-9  # the same steps but for rounding (1e-16), which some hundred steps and tens of hits can raise


def examples(count):
    """The same `count` examples in every run, in the quick tier a quarter of them; no search for smaller ones (each would
    be compiled), no time limit."""
    return settings(
        max_examples=math.ceil(count * settings().max_examples / 100), derandomize=True, deadline=None, database=None,
        phases=[Phase.generate], report_multiple_bugs=False,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
    )  # fmt: skip


@dataclass(frozen=True)
class Link:
    """An element between two bodies (b may be GROUND). kind: shaft, damper, lash, mesh or gear; v: its numbers.

    carrier: the body that carries the axes of a mesh, or None for the ground.
    """

    kind: str
    a: int
    b: int
    v: dict
    carrier: int | None = None


@dataclass(frozen=True)
class Plan:
    """A train: inertias, start angles and speeds of the bodies, links, and a torque (body, amplitude, frequency)."""

    J: tuple
    phi: tuple
    w: tuple
    links: tuple
    torque: tuple | None

    @property
    def tied(self):
        """Bodies that hang on another by an ideal gear: their starts follow."""
        return {link.b for link in self.links if link.kind == "gear"}


def gain(link):
    """phi_b / phi_a where the deflection stays zero."""
    if "teeth" not in link.v:
        return Fraction(1)
    return Fraction(link.v["teeth"][0], link.v["teeth"][1]) * (-1 if link.v["external"] else 1)


def quarters(low, high):
    return st.integers(low, high).map(lambda i: i / 4)


teeth = st.tuples(st.integers(10, 30), st.integers(10, 30))
c_or_none = st.one_of(st.none(), quarters(1, 8))
LAWS = {
    "shaft": {"k": quarters(200, 2000), "c": c_or_none},
    "damper": {"c": quarters(1, 8)},
    "lash": {"k": quarters(200, 2000), "c": c_or_none, "half_gap": st.integers(1, 5).map(lambda i: i / 100)},
    "mesh": {
        "teeth": teeth, "external": st.booleans(), "k": st.integers(1, 5).map(lambda i: i * 1e4),
        "c": st.one_of(st.none(), quarters(40, 400)), "ripple": st.sampled_from([None, 0.25]),
        "half_gap": st.one_of(st.none(), st.integers(1, 5).map(lambda i: i / 1e3)),
    },
    "gear": {"teeth": teeth, "external": st.booleans()},
}  # fmt: skip
COMPLIANT = ("shaft", "damper", "lash", "mesh")


@st.composite
def plans(draw, kinds=(*COMPLIANT, "gear"), losses=True, loops=True, free=False, torque=True):
    """A random tree, up to two further links that close loops, up to one to ground; not for free trains."""
    n = draw(st.integers(2, 5))

    def link(a, b, among):
        kind = draw(st.sampled_from(among))
        v = {name: draw(law) for name, law in LAWS[kind].items()}
        others = [i for i in range(max(a, b)) if i not in (a, b)] if kind == "mesh" else []
        carrier = draw(st.sampled_from([None, *others])) if others else None
        return Link(kind, a, b, v if losses else v | {"c": None} if "c" in v else v, carrier)

    among = tuple(k for k in kinds if losses or k != "damper")
    links = [link(draw(st.integers(0, i - 1)), i, among) for i in range(1, n)]
    soft = tuple(k for k in among if k != "gear")
    for _ in range(draw(st.integers(0, 2)) if loops and n > 2 else 0):
        a = draw(st.integers(0, n - 2))
        links.append(link(a, draw(st.integers(a + 1, n - 1)), soft))
    if not free and draw(st.booleans()):
        links.append(link(draw(st.integers(0, n - 1)), GROUND, tuple(k for k in soft if k != "mesh")))
    numbers = lambda low, high: tuple(draw(quarters(low, high)) for _ in range(n))  # noqa: E731
    J, phi, w = numbers(1, 8), tuple(x / 10 for x in numbers(-4, 4)), numbers(-8, 8)
    applied = (draw(st.integers(0, n - 1)), draw(quarters(4, 40)), draw(quarters(8, 80))) if torque else None
    return Plan(J, phi, w, tuple(links), applied)


@dataclass(frozen=True)
class Units:
    """How many new units one old unit is: length, time, mass. A number of an old unit is multiplied by these."""

    length: float = 1.0
    time: float = 1.0
    mass: float = 1.0

    @property
    def J(self):
        return self.mass * self.length**2


def block(link, flip, u):
    """The block of a link, and the names of its flanges at a and b."""
    v, torque = dict(link.v), u.J / u.time**2
    c = None if v.get("c") is None else v["c"]
    ends = ("b", "a") if flip else ("a", "b")
    if link.kind == "shaft":
        return gb.Shaft(k=v["k"] * torque, c=c and c * u.J / u.time), ends
    if link.kind == "damper":
        return gb.Damper(c=c * u.J / u.time), ends
    if link.kind == "lash":
        law = gb.Lash(k=v["k"] * torque, c=c and c * u.J / u.time, half_gap=v["half_gap"], contact_damping="always")
        return law, ends
    z = v["teeth"][::-1] if flip else v["teeth"]
    if link.kind == "gear":
        return gb.IdealGear(teeth=z, external=v["external"]), ends
    law = gb.GearMesh(
        teeth=z, external=v["external"], r_base=tuple(0.01 * u.length * i for i in z), k=v["k"] * u.mass / u.time**2,
        c=c and c * u.mass / u.time, contact_damping="always",
        backlash=None if v["half_gap"] is None else gb.Backlash(half_gap=v["half_gap"] * u.length),
        stiffness_variation=None if v["ripple"] is None else gb.Fourier(cos=(v["ripple"],), driven_by=20.0 / u.time),
    )  # fmt: skip
    return law, ("wheel", "pinion") if flip else ("pinion", "wheel")


def train(plan, order=None, flips=(), units=None, name="body{}"):
    """The plan from blocks. order: in which parts are added; flips: links turned round; units: see Units."""
    u, rig, handles = units or Units(), gb.Drivetrain("random"), {}
    tied = plan.tied
    parts = {
        ("body", i): gb.Inertia(J=J * u.J, **({} if i in tied else {"phi0": plan.phi[i], "w0": plan.w[i] / u.time}))
        for i, J in enumerate(plan.J)
    }
    parts |= {("link", i): block(link, i in flips, u)[0] for i, link in enumerate(plan.links)}
    if plan.torque:
        _, size, w = plan.torque
        parts["drive", 0] = gb.Torque(tau=size * u.J / u.time**2 * gb.cos(w / u.time * gb.time))
    if any(link.b == GROUND for link in plan.links):
        parts["ground", 0] = gb.Fixed()
    keys = list(parts)
    for key in keys if order is None else [keys[i] for i in np.random.default_rng(order).permutation(len(keys))]:
        kind, i = key
        handles[key] = rig.add(name.format(i) if kind == "body" else f"{kind}{i}", parts[key])
    for i, link in enumerate(plan.links):
        ends = block(link, i in flips, u)[1]
        far = handles["ground", 0].flange if link.b == GROUND else handles["body", link.b].a
        rig.connect(handles["body", link.a].b, getattr(handles["link", i], ends[0]))
        rig.connect(getattr(handles["link", i], ends[1]), far)
        if link.carrier is not None:
            rig.connect(handles["link", i].carrier, handles["body", link.carrier].a)
    if plan.torque:
        rig.connect(handles["drive", 0].flange, handles["body", plan.torque[0]].a)
    return rig


def motion(run, plan, name="body{}", time=1.0):
    """Angles and speeds of all bodies, shape (2, bodies, samples); time: new units of one old one."""
    bodies = [name.format(i) for i in range(len(plan.J))]
    return np.array([[run[f"{b}.phi"] for b in bodies], [run[f"{b}.w"] * time for b in bodies]])


def apart(one, other):
    """The largest difference of angles and of speeds, each against the largest of its kind."""
    scale = np.maximum(np.abs(one).max(axis=(1, 2)), 1e-3)
    return float((np.abs(one - other).max(axis=(1, 2)) / scale).max())


def pull(link, phi, w, t):
    """What an element exerts on its two bodies and the carrier at these angles and speeds, written out once more."""
    v, c = link.v, link.v.get("c") or 0.0
    dead = lambda x, b: x - b if x > b else x + b if x < -b else 0.0  # noqa: E731
    if link.kind == "mesh":
        r1, r2 = (0.01 * z for z in v["teeth"])
        r2 = r2 if v["external"] else -r2
        levers = np.array([r1, r2, -r1 - r2])
        k = v["k"] * (1 + (v["ripple"] or 0.0) * np.cos(20.0 * t))
        return -levers * (c * (levers @ w) + k * dead(levers @ phi, v["half_gap"] or 0.0))
    twist, rate = phi[1] - phi[0], w[1] - w[0]
    torque = v.get("k", 0.0) * dead(twist, v.get("half_gap", 0.0)) + c * rate
    return np.array([torque, -torque, 0.0])


@given(plans())
@examples(12)
def test_accelerations_are_those_of_newton_and_euler(plan):
    """J alpha = torques of all elements + reactions of the rigid gears, with a dense solver."""
    n, first = len(plan.J), gb.simulate(train(plan), t=[0.0])
    phi, w = (values[:, 0] for values in motion(first, plan))
    torque, ties = np.zeros(n + 1), []
    for link in plan.links:
        at = [link.a, link.b, GROUND if link.carrier is None else link.carrier]  # the ground is entry -1
        if link.kind == "gear":
            ties.append(np.eye(n)[link.b] - float(gain(link)) * np.eye(n)[link.a])
        else:
            np.add.at(torque, at, pull(link, np.append(phi, 0.0)[at], np.append(w, 0.0)[at], 0.0))
    if plan.torque:
        torque[plan.torque[0]] += plan.torque[1]
    G = np.array(ties).reshape(-1, n)
    whole = np.block([[np.diag(plan.J), G.T], [G, np.zeros((len(G), len(G)))]])
    alpha = np.linalg.solve(whole, np.append(torque[:n], np.zeros(len(G))))[:n]
    ours = np.array([first[f"body{i}.alpha"][0] for i in range(n)])
    # differences of angles of 1 rad times stiffnesses of up to 5e4 N m/rad on 0.25 kg m2
    assert np.abs(ours - alpha).max() <= 1e-12 * max(1.0, np.abs(torque).max() / min(plan.J), 1e4)
    assert np.abs(G @ phi).max(initial=0) < 1e-14 and np.abs(G @ w).max(initial=0) < 1e-14


@given(plans(), st.integers(0, 1000))
@examples(12)
def test_order_and_names_of_components_do_not_change_the_motion(plan, seed):
    run = gb.simulate(train(plan), **TIGHT)
    other = gb.simulate(train(plan, order=seed, name="z{}_wheel"), **TIGHT)
    assert apart(motion(run, plan), motion(other, plan, "z{}_wheel")) < NEAR


@given(plans(), st.sets(st.integers(0, 6)))
@examples(12)
def test_elements_turned_round_give_the_same_motion_and_opposite_signs(plan, flips):
    run, other = gb.simulate(train(plan), **TIGHT), gb.simulate(train(plan, flips=flips), **TIGHT)
    assert apart(motion(run, plan), motion(other, plan)) < NEAR
    for i, link in enumerate(plan.links):
        sign = -1 if i in flips else 1
        if link.kind in ("shaft", "lash"):
            twist = np.abs(run[f"link{i}.twist"]).max()
            assert np.abs(sign * other[f"link{i}.twist"] - run[f"link{i}.twist"]).max() <= NEAR * max(1, twist)
        elif link.kind == "mesh":  # the deflection of an external mesh has no direction
            sign = 1 if link.v["external"] else sign
            force = np.abs(run[f"link{i}.force"]).max()
            assert np.abs(sign * other[f"link{i}.force"] - run[f"link{i}.force"]).max() <= 1e3 * NEAR * max(1, force)


@given(plans(), st.tuples(*[st.sampled_from([-40, 40])] * 2))
@examples(8)
def test_units_of_length_and_mass_that_are_powers_of_two_change_no_bit(plan, powers):
    # 2^40 is 1e12: no tolerance and no threshold may know what a metre or a kilogram is
    units = Units(length=2.0 ** powers[0], mass=2.0 ** powers[1])
    run, other = gb.simulate(train(plan), **TIGHT), gb.simulate(train(plan, units=units), **TIGHT)
    assert (run.stats.steps, run.stats.events) == (other.stats.steps, other.stats.events)
    assert np.array_equal(motion(run, plan), motion(other, plan))


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:.*implausible")  # in metres, which these are not
@given(plans(), st.tuples(*[st.sampled_from([1e-12, 1.0, 1e12])] * 3))
@examples(8)
def test_other_units_of_length_time_and_mass_scale_the_motion(plan, factors):
    units = Units(*factors)
    run = gb.simulate(train(plan), **TIGHT)
    other = gb.simulate(train(plan, units=units), **(TIGHT | {"t": T * units.time}))
    assert run.stats.events == other.stats.events
    assert apart(motion(run, plan), motion(other, plan, time=units.time)) < NEAR


@given(plans(), st.lists(st.integers(1, 999), min_size=1, max_size=12, unique=True))
@examples(8)
def test_the_grid_of_samples_does_not_change_a_bit(plan, grid):
    model, few = gb.build(train(plan)), np.array(sorted(grid)) / 1000
    all_times = np.unique(np.concatenate([few, T]))
    options = {"rtol": 1e-8, "method": "dp8"}
    sparse = motion(gb.simulate(model, t=np.append(few, 1.0), **options), plan)
    dense = motion(gb.simulate(model, t=all_times, **options), plan)
    assert np.array_equal(sparse[:, :, :-1], dense[:, :, np.isin(all_times, few)])
    with model.library.open() as sim:  # and through communication points, as an FMU goes
        sim.parameters[:] = model.values
        assert sim.start(Options(Method.DP8, 1, 1e-8, 0.0, np.inf, 1.0), 0.0) == Code.DONE
        names = [q.name for q in model.program.outputs]
        where = [names.index(f"body{i}.phi") for i in range(len(plan.J))]
        for column, t in enumerate(few):
            assert sim.advance(float(t)) == Code.DONE
            assert np.array_equal(sim.outputs()[where], sparse[0, :, column])


@given(plans())
@examples(12)
def test_every_ledger_closes_to_the_tolerance(plan):
    for rtol in (1e-6, 1e-10):
        run = gb.simulate(train(plan), t=[1.0], rtol=rtol, method="dp8")
        assert run.energy.residual <= 200 * rtol + 1e-14  # some hundred steps


@pytest.mark.long
@given(plans(losses=False, torque=False))
@examples(12)
def test_a_train_without_losses_and_loads_keeps_its_energy(plan):
    quiet = replace(
        plan, links=tuple(replace(x, v=x.v | {"ripple": None}) if x.kind == "mesh" else x for x in plan.links)
    )
    run = gb.simulate(train(quiet), **TIGHT)
    assert run.energy.supplied == {} and run.energy.dissipated == {}
    # what is stored at the end, against the largest stored on the way
    assert abs(run.energy.end - run.energy.start) <= 200 * 1e-11 * run.energy.largest_stored


@pytest.mark.long
@given(plans(loops=False, free=True, torque=False))
@examples(12)
def test_a_free_tree_keeps_the_momentum_of_its_rigid_motion(plan):
    """sum J g w with g the speeds of the bodies where nothing deflects; without gears all g are 1.

    A gear or a mesh on the ground takes torque there, one on a carrier does not.
    """
    g = [Fraction(1)] * len(plan.J)
    for link in plan.links:
        carried = Fraction(0) if link.carrier is None else g[link.carrier]
        g[link.b] = carried + (g[link.a] - carried) * gain(link)
    _, w = motion(gb.simulate(train(plan), **TIGHT), plan)
    share = np.array(plan.J)[:, None] * np.array([float(x) for x in g])[:, None] * w
    assert np.abs(share.sum(axis=0) - share.sum(axis=0)[0]).max() <= 1e-9 * np.abs(share).sum(axis=0).max()


@given(plans(kinds=("shaft", "damper", "lash"), free=True))
@examples(8)
def test_the_angular_momentum_of_a_free_train_follows_the_torque(plan):
    _, size, w = plan.torque
    _, speeds = motion(gb.simulate(train(plan), **TIGHT), plan)
    momentum = np.array(plan.J) @ speeds
    impulse = size / w * np.sin(w * T)
    assert np.abs(momentum - momentum[0] - impulse).max() <= 1e-9 * max(1.0, np.abs(momentum).max(), size / w)


@pytest.mark.long
@given(plans(kinds=("shaft", "lash", "mesh")), st.integers(0, 10))
@examples(8)
def test_a_shaft_in_two_halves_tends_to_the_whole_one(plan, which):
    """Twice k and c on both sides of a disc of vanishing inertia; the difference falls with that inertia."""
    shafts = [i for i, link in enumerate(plan.links) if link.kind == "shaft"]
    if not shafts:
        return
    i = shafts[which % len(shafts)]
    link, n = plan.links[i], len(plan.J)
    half = {"k": 2 * link.v["k"], "c": None if link.v["c"] is None else 2 * link.v["c"]}
    ends = np.array([link.a, link.b])
    middle = [float(np.append(x, 0.0)[ends].mean()) for x in (plan.phi, plan.w)]  # both halves twisted alike
    links = [x for j, x in enumerate(plan.links) if j != i]
    links += [Link("shaft", link.a, n, half), Link("shaft", n, link.b, half)]
    true = motion(gb.simulate(train(plan), **TIGHT), plan)
    gaps = []
    for J in (1e-4, 1e-6):
        split = replace(plan, J=(*plan.J, J), phi=(*plan.phi, middle[0]), w=(*plan.w, middle[1]), links=tuple(links))
        gaps.append(apart(true, motion(gb.simulate(train(split), **TIGHT), split)[:, :n]))
    # a disc of J takes part in J/0.25 of the motion of the lightest body; hits without damping raise that by up to 1e3
    assert gaps[1] < 5e-3 and gaps[1] < 0.1 * gaps[0] + NEAR


@pytest.mark.long
@given(st.integers(2, 6), quarters(4, 40), c_or_none)
@examples(6)
def test_segments_are_the_chain_that_they_stand_for(count, k, c):
    ends = gb.Drivetrain("segments")
    at = [ends.add("left", gb.Inertia(J=1.0, w0=2.0)), ends.add("right", gb.Inertia(J=0.5))]
    ends.chain(at[0], ends.add("shaft", gb.Shaft(k=k, c=c, segments=count, J=0.4)), at[1])
    lumps = [0.4 / count / (2 if i in (0, count) else 1) for i in range(count + 1)]
    chain = [Link("shaft", i, i + 1, {"k": k * count, "c": c and c * count}) for i in range(count)]
    J = (1.0 + lumps[0], *lumps[1:-1], 0.5 + lumps[-1])
    plan = Plan(J, (0.0,) * (count + 1), (2.0, *[0.0] * count), tuple(chain), None)
    one, other = gb.simulate(ends, **TIGHT), gb.simulate(train(plan), **TIGHT)
    # strong damping binds the steps by stability; there the dense output (order 7) errs by some hundred rtol
    assert np.abs(one["right.phi"] - other[f"body{count}.phi"]).max() < 2e-8
    assert np.abs(one["left.w"] - other["body0.w"]).max() < 2e-8
