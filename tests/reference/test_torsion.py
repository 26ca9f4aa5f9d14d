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


def test_a_gear_pair_jumps_to_the_upper_branch_where_the_reference_does():
    table = _table("gear_pair_sweep_up.json")
    w = gb.Parameter("w", 0.5, "rad/s")
    rig = gb.Drivetrain("Kahraman and Singh")
    drive = rig.add("drive", gb.Torque(tau=table["Fm"] + table["Fa"] * w**2 * gb.cos(w * gb.time)))
    body = rig.add("body", gb.Inertia(J=1.0))
    lash = rig.add("lash", gb.Lash(k=1.0, half_gap=1.0, c=2 * table["zeta"], contact_damping="always"))
    rig.chain(drive, body, lash, rig.add("ground", gb.Fixed()))
    model, start = gb.build(rig), "static"
    for row in table["sweep_up"]:
        # the table was sampled 64 times a period over 40 periods, both ends counted
        t = 2 * np.pi / row["W"] * (200 + np.arange(2561) / 64)
        run = gb.simulate(
            model, t=t, rtol=1e-9, parameters={"w": row["W"]}, initial=start, outputs=["body.phi", "body.w"]
        )
        x = run["body.phi"]
        assert (x.mean(), x.min(), x.max()) == pytest.approx((row["mean"], row["xmin"], row["xmax"]), rel=1e-6)
        assert x.std() == pytest.approx(row["rms"], rel=1e-6)  # the reference ran at a relative tolerance of 1e-8
        start = {"body.phi": float(x[-1]), "body.w": float(run["body.w"][-1])}
