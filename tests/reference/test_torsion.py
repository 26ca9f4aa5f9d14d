"""Natural frequencies and a frequency sweep against numbers of others and of independent programs."""

import json
from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb

DATA = Path(__file__).parents[1] / "data"

NEAR = 1e-5  # the tables have two decimals of frequencies above 700 Hz, or more digits than that
ZERO = 1e-3  # rad/s: what rounding may leave of a free rotation, beside frequencies of 500 to 80,000 rad/s


def _table(name):
    return json.loads((DATA / f"torsion_{name}").read_text(encoding="utf-8"))


@pytest.mark.parametrize("case", ["ot_shaft", "friswell_9_7_1"])
@pytest.mark.few(1)
def test_torsional_trains_have_the_frequencies_of_the_book(case):
    numbers = _table("torsional_friswell.json")["cases"][case]
    rig = gb.Drivetrain(case)
    links = []
    for i, J in enumerate(numbers["J"]):
        links.append(rig.add(f"disc{i}", gb.Inertia(J=J)))
        if i < len(numbers["k"]):
            links.append(rig.add(f"shaft{i}", gb.Shaft(k=numbers["k"][i])))
    rig.chain(*links)
    found = gb.modes(rig)
    assert found.free == 1
    assert found.hertz[0] == 0.0
    assert found.bound < ZERO
    assert found.hertz[1:] == pytest.approx(numbers["computed"][1:], rel=NEAR)


class Spring(gb.Block):
    """A spring over a linear form of six coordinates: energy k/2 (sum c_i phi_i)^2."""

    f0, f1, f2, f3, f4, f5 = (gb.Flange(f"coordinate {i}") for i in range(6))
    k: float = gb.param("stiffness", "N/m")
    c: tuple = gb.param("coefficients of the coordinates", many=True)

    def physics(self, s):
        form = sum(c * f.phi for c, f in zip(s.c, (s.f0, s.f1, s.f2, s.f3, s.f4, s.f5), strict=True))
        yield gb.Potential(s.k * form**2 / 2)
        yield gb.Energy(stored=s.k * form**2 / 2)


def _planetary(p, n):
    """Lin and Parker (1999): x, y and u = r theta of carrier, ring and sun; radial, tangential and u of each planet.

    Every coordinate is a body of its own that 'turns' by metres, with a mass (or I/r^2) for its inertia.
    """
    rig = gb.Drivetrain(f"{n} planets")
    body = {h + x: rig.add(f"{h}_{x}", gb.Inertia(J=p[("I" if x == "u" else "m") + h])) for h in "crs" for x in "xyu"}
    for i in range(n):
        body |= {f"{i}{x}": rig.add(f"p{i}_{x}", gb.Inertia(J=p["Ip" if x == "u" else "mp"])) for x in "zeu"}
    ground = rig.add("ground", gb.Fixed())
    for h in "crs":
        for x in "xyu":
            k = p[f"k{h}u" if x == "u" else f"k{h}"]
            if k:
                rig.chain(body[h + x], rig.add(f"support_{h}{x}", gb.Shaft(k=k)), ground)
    a, sin, cos = p["alpha"], np.sin, np.cos
    for i in range(n):
        psi = 2 * np.pi * i / n
        for name, k, h, form in (
            ("sun", "ksp", "s", (-sin(psi - a), cos(psi - a), 1.0, -sin(a), -cos(a), 1.0)),
            ("ring", "krp", "r", (-sin(psi + a), cos(psi + a), 1.0, sin(a), -cos(a), -1.0)),
            ("radial", "kp", "c", (cos(psi), sin(psi), 0.0, -1.0, 0.0, 0.0)),
            ("tangential", "kp", "c", (-sin(psi), cos(psi), 1.0, 0.0, -1.0, 0.0)),
        ):
            spring = rig.add(f"{name}{i}", Spring(k=p[k], c=tuple(map(float, form))))
            for j, x in enumerate((h + "x", h + "y", h + "u", f"{i}z", f"{i}e", f"{i}u")):
                rig.connect(getattr(spring, f"f{j}"), body[x].a)
    return rig


@pytest.mark.parametrize("n", [3, 4])
@pytest.mark.few(1)
def test_a_planetary_with_lateral_motion_has_the_frequencies_of_lin_and_parker(n):
    table = _table("planetary_lin_parker_N3_N4.json")
    known = table["computed"][str(n)]
    # translational modes come in pairs, planet modes n - 3 times
    true = sorted([*known["rotational"], *(2 * known["translational"]), *((n - 3) * known["planet"])])
    found = gb.modes(_planetary(table["parameters"], n))
    assert found.free == 1
    assert found.hertz[0] == 0.0
    assert found.bound < ZERO
    assert found.hertz[1:] == pytest.approx(true[1:], rel=NEAR)
    assert np.abs(found.damping).max() < 1e-10  # nothing is damped


PAIR = _table("gear_pair_sweep_up.json")


@pytest.fixture(scope="module")
def pair():
    """Kahraman and Singh's gear pair: x'' + 2 zeta x' + g(x) = Fm + Fa w^2 cos(w t)."""
    w = gb.Parameter("w", 0.5, "rad/s")
    rig = gb.Drivetrain("Kahraman and Singh")
    drive = rig.add("drive", gb.Torque(tau=PAIR["Fm"] + PAIR["Fa"] * w**2 * gb.cos(w * gb.time)))
    body = rig.add("body", gb.Inertia(J=1.0))
    lash = rig.add("lash", gb.Lash(k=1.0, half_gap=1.0, c=2 * PAIR["zeta"], contact_damping="always"))
    rig.chain(drive, body, lash, rig.add("ground", gb.Fixed()))
    return gb.build(rig)


@pytest.mark.long
def test_the_sweep_of_a_gear_pair_is_that_of_the_reference(pair):
    rows = PAIR["sweep_up"]
    speeds = np.array([row["W"] for row in rows])
    n = 64 * 40
    found = gb.speed_sweep(pair, "w", speeds, of="body.phi", initial="static", rtol=1e-9, samples=64)
    # the table was sampled 64 times a period over 40 periods, both ends counted: one value more than is here
    last = -found.states[0, :, found.names.index("lash.coordinate")]
    mean = (n * found.mean[0] + last) / (n + 1)
    rms = np.sqrt((n * (found.rms[0] ** 2 + found.mean[0] ** 2) + last**2) / (n + 1) - mean**2)
    for name, ours in (("mean", mean), ("rms", rms), ("xmin", found.low[0]), ("xmax", found.high[0])):
        assert ours == pytest.approx([row[name] for row in rows], rel=1e-6)  # the reference ran at 1e-8
    up, down = found.jumps
    assert (up.direction, down.direction) == ("up", "down")
    assert 0.8 < up.last < up.first < 0.85 and up.first - up.last <= 1e-3 * up.first
    # without contact lost the motion is linear: it loses contact where its amplitude is Fm/k, for u = w^2 at
    # (Fa u / Fm)^2 = (1 - u)^2 + (2 zeta)^2 u; there it cannot jump yet
    ratio, loss = (PAIR["Fa"] / PAIR["Fm"]) ** 2, (2 * PAIR["zeta"]) ** 2
    grazes = np.sqrt(min(np.roots([1 - ratio, loss - 2, 1]).real))
    assert grazes < up.last < 1.02 * grazes
    assert 0.70 < down.first < down.last < 0.71


@pytest.mark.long
def test_jumps_of_the_gear_pair_are_folds_with_an_unstable_branch_between(pair):
    branch = gb.continue_orbit(pair, "w", (0.5, 1.2), section=gb.stroboscopic("w"), of="body.phi", initial="static")
    assert [mark.kind for mark in branch.marks] == ["grazing", "fold", "fold"] and branch.values[-1] == pytest.approx(
        1.2
    )
    graze, top, bottom = branch.marks
    ratio, loss = (PAIR["Fa"] / PAIR["Fm"]) ** 2, (2 * PAIR["zeta"]) ** 2
    known = np.sqrt(min(np.roots([1 - ratio, loss - 2, 1]).real))  # as in the sweep
    assert graze.value == pytest.approx(known, rel=1e-6) and graze.words.startswith("0 events")
    # a sweep jumps next to the folds: it passes them by what it needs to leave, and stays on a branch that is there
    found = gb.speed_sweep(pair, "w", np.linspace(0.6, 1.0, 41), of="body.phi", initial="static")
    up, down = found.jumps
    for jump, fold in ((up, top), (down, bottom)):
        assert fold.bracket[1] - fold.bracket[0] <= 1e-3 * fold.value
        assert abs(jump.last - fold.value) <= 1e-3 * fold.value and abs(jump.first - fold.value) <= 1e-3 * fold.value
    between = slice(top.number + 1, bottom.number)
    assert not branch.stable[between].any() and bottom.number - top.number > 10
    assert branch.stable[: top.number].all() and branch.stable[bottom.number + 1 :].all()
    # the branch and the sweep are one motion where both are stable
    for row, part in ((0, slice(0, top.number)), (1, slice(bottom.number + 1, None))):
        near = np.interp(found.values, branch.values[part], branch.rms[part])
        inside = (found.values > bottom.value + 0.02) & (found.values < top.value - 0.02)
        assert found.rms[row][inside] == pytest.approx(near[inside], rel=2e-3)  # between points of the branch


@pytest.mark.long
def test_the_sweep_down_is_that_of_another_program(pair):
    """x'' = Fm + Fa w^2 cos(w t) - 2 zeta x' - g(x), by scipy from corner to corner."""
    from scipy.integrate import solve_ivp

    zeta, Fm, Fa = PAIR["zeta"], PAIR["Fm"], PAIR["Fa"]
    speeds = np.array([0.6, 0.69, 0.72, 0.76, 0.8, 0.84, 0.95, 1.1])
    found = gb.speed_sweep(pair, "w", speeds, of="body.phi", initial="static", rtol=1e-10, samples=64)

    def rates(t, y, w, side):
        g = y[0] - side if side else 0.0
        return y[1], Fm + Fa * w**2 * np.cos(w * t) - 2 * zeta * y[1] - g

    def period(w, y):
        samples, end = [], 2 * np.pi / w
        times, t = np.arange(64) / 64 * end, 0.0
        while t < end:
            side = float(np.sign(y[0])) if abs(y[0]) > 1 or (abs(y[0]) == 1 and y[0] * y[1] > 0) else 0.0

            def corner(_, y, *__, side=side):
                return y[0] ** 2 - 1 if side == 0 else y[0] * side - 1

            corner.terminal, corner.direction = True, -1 if side else 1
            run = solve_ivp(
                rates, (t, end), y, "DOP853", args=(w, side), events=corner, rtol=1e-11, atol=1e-13, dense_output=True
            )
            here = times[(times >= t) & (times < run.t[-1])]
            samples.append(run.sol(here)[0] if len(here) else np.empty(0))
            t, y = run.t[-1], run.y[:, -1]
            if run.status == 1:
                y = np.array([np.sign(y[0]), y[1]])
        return y, np.concatenate(samples)

    y = np.array([1 + Fm, 0.0])
    for j in reversed(range(len(speeds))):
        w = speeds[j]
        for _ in range(200):
            y, _ = period(w, y)
        y, x = period(w, y)
        ours = [found.mean[1, j], found.rms[1, j], found.low[1, j], found.high[1, j]]
        assert ours == pytest.approx([x.mean(), x.std(), x.min(), x.max()], rel=1e-6)
    assert found.jumps[-1].direction == "down" and 0.69 < found.jumps[-1].first < 0.72
