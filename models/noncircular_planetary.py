"""Non-circular planetary train of a reversing drive (W-W): sun 1 fixed, double-row planets on a driven carrier, sun 2 swings.

Dong, Li, Liu (Lanzhou University of Technology): two equal elliptical rows per planet, the second one ahead by beta,

    tan(F/2) = K tan(psi/2),  K = (1 + e)/(1 - e),     th_C = th_H - [chi(th_H) - chi(0)],  F(chi) = F(psi) + beta

so that a carrier that runs one way makes the output swing. Two models:

`build`, `figure_8`, `figure_9` and `figure_10` are the paper's five nondimensional coordinates, term by term, as blocks of
one's own without flanges: nothing acts back on the carrier, and the planets do not act on each other.

    x_H''   = F_H
    x_spi'' = E_sp w^2 sin w t - tau (cd xi x_spi' + kappa f(x_spi)) - tau (cd xi x_cpi' + kappa f(x_cpi))
    x_cpi'' = F + E_cp w^2 sin w t - tau (cd xi x_cpi' + kappa f(x_cpi))
    tau = 1 + mu lambda(t),   kappa = 1 + ka cos w t,   f the dead zone as a polynomial,   i = 1, 2

Friction, variation, errors and backlash are effects that can be taken away; lambda is a square wave with known switch times.

Reproduced: the equations; with set M1 and lambda = sgn sin(w t + phase) eight of the nine regimes that the paper prints
for its figures 8 to 10, "quasi-periodic" being periodic: one frequency excites a cascade in which areas contract, so
there is no torus. Not reproduced: ka = 0.5 is periodic where the print says chaotic (the Poincare set that it describes
lies in one region, as that of a periodic motion does); chaos begins at xi = 0.069, mu = 0.035 and ka = 1.565, in print
at 0.1, 0.085 and 1.8. The paper gives no parameters: M1 was fitted, and no single baseline of the three figures is
known. The polynomial decides: with the true dead zone (`exact=True`) the pattern of M1 is lost. f has the five PRINTED
coefficients, which fit the dead zone for abs(x) <= 2 and have false rest points at 0.437 and 0.854. Leaving abs(x) <= 2
is an event; where ka > 1 a motion that leaves may escape in finite time, and the run ends with that cause.

`physical` is the train in SI units: carrier at 300 rpm, planets with inertia, four meshes with a stiffness over the
angle from equivalent tooth numbers (ISO 6336-1), backlash, friction, transmission error, sun 2 under 30 N m; `rigid` is
its kinematics. The paper gives no beta (30 deg here), damping, gap, error or inertia of the load. Two planets 180 deg
apart cannot be assembled between the same suns (`print(assembly())`), so each has suns of its own here, keyed on 180
deg further: both ask for the same. The mate of the printed ellipse is an equal one for a centre distance of 249.993 mm
alone; at the printed 250 mm it drifts by -0.0254 deg a turn. Lever arms are r cos(20 deg): the increment of the
pressure angle, up to 27.6 deg and of opposite sign on the two flanks, is left out, and so is the unbalance of planets
that turn about a focus.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import gearblocks as gb

# -- the paper's nondimensional equations ------------------------------------------------------------------------------


class Sliding(gb.Effect):
    """Friction of the teeth: every mesh force times tau = 1 + mu lambda."""

    mu: Any = gb.param("coefficient of friction", ge=0)
    wave: Any = gb.signal("direction of sliding lambda, +1 or -1")


class Variation(gb.Effect):
    """Stiffness over time: kappa = 1 + ka cos w t."""

    ka: Any = gb.param("amplitude of the stiffness over its mean", ge=0)


class Errors(gb.Effect):
    """Errors of both meshes, by their second derivatives E w^2 sin w t."""

    E_sp: Any = gb.param("amplitude of the error of the mesh with sun 1")
    E_cp: Any = gb.param("amplitude of the error of the mesh with sun 2")


class Carrier(gb.Block):
    """The coordinate of the carrier: x_H'' = F_H, on which nothing acts back."""

    F: Any = gb.param("drive", default=0.0)
    x, v = gb.State("coordinate of the carrier"), gb.State("its rate")

    def physics(self, s: Any) -> Iterator[Any]:
        """A free ramp."""
        yield gb.Rate(s.x, s.v)
        yield gb.Rate(s.v, s.F)
        yield gb.Shows("x", s.x)


class Planet(gb.Block):
    """Both meshes of a planet: x_sp with sun 1, x_cp with sun 2, over half of the backlash; starts on the flanks."""

    w: Any = gb.param("frequency of the excitation", gt=0)
    xi: Any = gb.param("damping ratio", ge=0)
    cd: Any = gb.param("factor of the damping", default=2.0, symbol="c_d")
    F: Any = gb.param("load")
    friction: Sliding | None = gb.effect("friction of the teeth")
    variation: Variation | None = gb.effect("stiffness over time")
    errors: Errors | None = gb.effect("errors of the meshes")
    backlash: gb.Backlash | None = gb.effect("dead zone f", turns=True)
    x_sp, v_sp = gb.State("mesh with sun 1", start=-1.05), gb.State("its rate")
    x_cp, v_cp = gb.State("mesh with sun 2", start=1.05), gb.State("its rate")

    def physics(self, s: Any) -> Iterator[Any]:
        """The cascade: the mesh with sun 2 drives the one with sun 1."""
        tau, kappa, e_sp, e_cp = 1, 1, 0, 0
        if self.friction is not None:
            tau = s.named("tau", 1 + s.friction.mu * s.friction.wave, "factor of the friction")
        if self.variation is not None:
            kappa = s.named("kappa", 1 + s.variation.ka * gb.cos(s.w * s.time), "stiffness over its mean")
        if self.errors is not None:
            e_sp, e_cp = (e * s.w**2 * gb.sin(s.w * s.time) for e in (s.errors.E_sp, s.errors.E_cp))
        forces = []
        for name, x, v in (("sp", s.x_sp, s.v_sp), ("cp", s.x_cp, s.v_cp)):
            f = x
            if self.backlash is not None:
                f = s.named(f"f_{name}", self.backlash.deflection(s.backlash, x), "dead zone, over half of it")
                watches: list[Any] = [*self.backlash.watches(s.backlash, x)]
                yield from (gb.Switch(f"x_{name} {watch.name}", watch.surface) for watch in watches)
            yield gb.Shows(f"x_{name}", x)
            yield gb.Shows(f"v_{name}", v)
            forces.append(tau * (s.cd * s.xi * v + kappa * f))
        yield gb.Rate(s.x_sp, s.v_sp)
        yield gb.Rate(s.v_sp, e_sp - forces[0] - forces[1])
        yield gb.Rate(s.x_cp, s.v_cp)
        yield gb.Rate(s.v_cp, s.F + e_cp - forces[1])


@dataclass(frozen=True)
class Numbers:
    """A set of the nondimensional train. phase: of lambda = sgn sin(w t + phase), None: lambda = 1."""

    w: float
    F: float
    E_sp: float
    E_cp: float
    xi: float
    mu: float
    ka: float
    phase: float | None = None
    cd: float = 2.0


PRINTED = (0.0473, -0.3320, 0.4704, -0.1548, 0.0163)
"""Coefficients of x, x^3, ..., x^9 as the paper prints them."""
M1_ERROR = 0.0053561976622977644
FIGURE_8 = Numbers(
    0.98836496661677953, 0.0064601872333960031, M1_ERROR, M1_ERROR, 0.20, 0.05227569026671019, 0.7320427800322861,
    phase=4.5975370424507478,
)  # fmt: skip
FIGURE_9 = replace(FIGURE_8, xi=0.09169967575562357, mu=0.12, ka=0.9567405871782367)
FIGURE_10 = replace(FIGURE_8, xi=0.14280527538625362, ka=1.5)
SET_A = Numbers(1.2, 0.1, 0.1, 0.1, 0.05, 0.05, 0.3)
SWEEPS = {"xi": (FIGURE_8, (0.06, 0.07)), "mu": (FIGURE_9, (0.03, 0.04)), "ka": (FIGURE_10, (1.5, 1.6))}
"""What each figure varies, from where, and between which values its regime changes."""


def build() -> gb.Drivetrain:
    """Set M1, figure 8 at xi = 0.20: carrier and both planets, all five coordinates."""
    return nondimensional(FIGURE_8)


def figure_8(xi: float = 0.20, *, exact: bool = False) -> gb.Drivetrain:
    """Set M1 over the damping ratio: chaos below 0.069. One planet, since both do the same."""
    return nondimensional(replace(FIGURE_8, xi=xi), planets=1, exact=exact)


def figure_9(mu: float = 0.12, *, exact: bool = False) -> gb.Drivetrain:
    """Set M1 over the friction: chaos below 0.035. One planet."""
    return nondimensional(replace(FIGURE_9, mu=mu), planets=1, exact=exact)


def figure_10(ka: float = 1.5, *, exact: bool = False) -> gb.Drivetrain:
    """Set M1 over the variation of the stiffness: chaos above 1.565. One planet."""
    return nondimensional(replace(FIGURE_10, ka=ka), planets=1, exact=exact)


def nondimensional(n: Numbers, *, planets: int = 2, exact: bool = False) -> gb.Drivetrain:
    """The paper's equations, with a carrier where there are two planets; `w`, `xi`, `mu` and `ka` are Parameters.

    exact: the true dead zone in place of the printed polynomial.
    """
    rig = gb.Drivetrain("non-circular planetary, nondimensional")
    w, xi, mu, ka = (gb.Parameter(name, getattr(n, name)) for name in ("w", "xi", "mu", "ka"))
    square = gb.Table([0.0, 0.5, 1.0], [1.0, -1.0, 1.0], "step", periodic=True)
    wave = 1.0 if n.phase is None else square((w * gb.time + n.phase) / math.tau)
    gap = gb.Backlash(half_gap=1.0) if exact else gb.Backlash(half_gap=1.0, law="polynomial", coefficients=PRINTED)
    if planets > 1:
        rig.add("H", Carrier())
    for i in range(1, planets + 1):
        planet = Planet(
            w=w, xi=xi, cd=n.cd, F=n.F, friction=Sliding(mu=mu, wave=wave), variation=Variation(ka=ka),
            errors=Errors(E_sp=n.E_sp, E_cp=n.E_cp), backlash=gap,
        )  # fmt: skip
        rig.add(f"p{i}", planet)
    return rig


def regime(path: str, value: float, **options: Any) -> Any:
    """Label with evidence of one run of a figure: path "xi" (8), "mu" (9) or "ka" (10); options as of gb.classify."""
    rig = nondimensional(SWEEPS[path][0], planets=1)
    return gb.classify(rig, gb.stroboscopic("w"), parameters={path: value}, **options)


def threshold(path: str, within: float = 0.002) -> tuple[float, float]:
    """Two values of the parameter of a figure, at most `within` apart, of which one gives chaos: bisection by label."""
    low, high = SWEEPS[path][1]
    model = gb.build(nondimensional(SWEEPS[path][0], planets=1))

    def chaotic(value: float) -> bool:
        found = gb.classify(model, gb.stroboscopic("w"), parameters={path: value})
        return str(found.label) == "chaotic"

    below = chaotic(low)
    while high - low > within:
        middle = (low + high) / 2
        low, high = (middle, high) if chaotic(middle) == below else (low, middle)
    return low, high


def diagram(path: str, values: Any, **options: Any) -> Any:
    """The diagram of a figure: x_sp once a period over values of "xi", "mu" or "ka"; options as of gb.bifurcation."""
    rig = nondimensional(SWEEPS[path][0], planets=1)
    return gb.bifurcation(rig, path, values, section=gb.stroboscopic("w"), of="p1.x_sp", **options)


# -- the physical train, SI units ---------------------------------------------------------------------------------------

ECCENTRICITY, PARAMETER, MODULE, TEETH = 0.4632, 0.098178, 4e-3, 59  # -, m, m, -
LAW = gb.RatioLaw.ellipse(ECCENTRICITY)
POINTS = 72  # of the stiffness in a turn: the spline between them is right to 1e-6
PAIR = LAW.pair(2 * PARAMETER / (1 - ECCENTRICITY**2))


@dataclass(frozen=True)
class Train:
    """SI values. Given: I of a row, face width, speed, load; the others are chosen. Gap and error: along the line of action."""

    beta: float = math.radians(30)
    j_row: float = 0.1058
    j_output: float = 0.5
    j_carrier: float = 3.0
    face_width: float = 0.03
    pressure_angle: float = math.radians(20)
    damping: float = 65.0
    half_gap: float = 40e-6
    error: float = 5e-6
    mu: float = 0.05
    w: float = gb.rpm(300)
    load: float = 30.0


def physical(planets: int = 2) -> gb.Drivetrain:
    """The train at 300 rpm and 30 N m with all effects, rolling from the start."""
    return train(Train(), planets)


def rigid(planets: int = 1) -> gb.Drivetrain:
    """The train without compliance and what rests on it: its kinematics."""
    return train(Train(), planets).without("*.compliance")


def reversing() -> gb.Scene:
    """One turn of the carrier, from the second on: the largest moment of a mesh with sun 2, to 5 %."""
    turn = math.tau / Train().w
    asked = gb.peak("p1_output.moment", after=turn)
    return gb.Scene(physical(1), t_end=2 * turn, quantity=asked, within=0.05, name="reversing drive")


def train(n: Train, planets: int = 1) -> gb.Drivetrain:
    """Carrier driven at a speed, sun 1 held, each planet between suns of its own on common shafts, load on sun 2."""
    rig = gb.Drivetrain("non-circular planetary train")
    w = gb.Parameter("w", n.w, "rad/s")
    source, held = rig.add("drive", gb.Speed(w=w)), rig.add("sun1", gb.Fixed())
    carrier = rig.add("carrier", gb.Inertia(J=n.j_carrier))
    ahead = float(LAW.inverse(n.beta))
    m = float(LAW.m(0.0))
    output = rig.add("output", gb.Inertia(J=n.j_row + n.j_output, phi0=0.0, w0=n.w * (1 - m / float(LAW.m(ahead)))))
    rig.connect(source.flange, carrier.a)
    rig.connect(rig.add("load", gb.Torque(tau=gb.Parameter("load_torque", -n.load, "N m"))).flange, output.b)
    for i in range(1, planets + 1):
        planet = rig.add(f"p{i}", gb.Inertia(J=2 * n.j_row, phi0=0.0, w0=n.w * (1 + m)))
        for row, sun, phase in (("fixed", held.flange, 0.0), ("output", output.a, -ahead)):
            mesh = rig.add(f"p{i}_{row}", _mesh(n, w, phase))
            rig.connect(sun, mesh.a)
            rig.connect(planet.a, mesh.b)
            rig.connect(carrier.a, mesh.carrier)
    return rig


def _mesh(n: Train, w: gb.Parameter, phase: float) -> gb.NonCircularGear:
    """A row: sun (the driver of the law) and planet. The teeth pass with TEETH w on average."""
    arm = float(PAIR.distance / 2 * math.cos(n.pressure_angle))  # mean lever arm
    teeth = TEETH * w
    square = gb.Table([0.0, 0.5, 1.0], [1.0, -1.0, 1.0], "step", periodic=True)
    return gb.NonCircularGear(
        law=LAW, external=True, phase=phase, k=stiffness_about_planet(n), c=n.damping, contact_damping="clipped",
        backlash=gb.Backlash(half_gap=n.half_gap / arm),
        transmission_error=gb.Harmonic(sin=(n.error / arm,), driven_by=teeth),
        friction=gb.ToothFriction(mu=n.mu, direction="square_wave", wave=square(teeth * gb.time / math.tau)),
    )  # fmt: skip


def stiffness_about_planet(n: Train) -> gb.Table:
    """k r_2^2 cos^2(alpha) [N m/rad] over the angle of the sun, k after ISO 6336-1 with equivalent tooth numbers."""
    theta = np.linspace(0.0, math.tau, POINTS + 1)
    k = PAIR.mesh_stiffness(theta, module=MODULE, face_width=n.face_width)
    about = k * (PAIR.radii(theta)[1] * math.cos(n.pressure_angle)) ** 2
    about[-1] = about[0]
    return gb.Table(theta, about, "cubic", periodic=True)


def assembly(beta: float = math.radians(30), spacing: float = math.pi) -> Any:
    """Whether a second planet fits between the same suns: print it for the sentence."""
    return LAW.planet_assembly(beta, spacing)


def flanks() -> Any:
    """The 59 teeth of a row, by rack generation."""
    return PAIR.flanks(MODULE, TEETH, pressure_angle=math.radians(20))
