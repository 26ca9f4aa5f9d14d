"""Involute spline coupling with backlash between four discs: period 1, 2, 5 and chaos from one set of numbers.

Xue, Wang, Yuan (2015), J. Harbin Inst. Tech. 47(1) 107-111, doi 10.11918/j.issn.0367-6234.2015.01.016:
an input disc, the external and the internal spline, an output disc; shafts on both sides; the spline as one contact
with varying stiffness, a dead zone of half width b and damping that also acts in the gap.

Of the numbers the paper gives the geometry, the torque and the mean stiffness; the inertias, shafts, backlash, damping
and start values it does not give. Two sets fill the gap:

`build` uses set S. It was fitted so that all four regimes of the paper come out (300 rpm period 1, 348 rpm period 2,
360 rpm period 5, 1080 rpm chaos). It is not the authors' set, and its inertias (2 to 8 kg m2) and its clearance
(0.8 mm) are far from an aerospace spline.

`steel` has the numbers of steel discs (2e-4 to 1e-2 kg m2) and a backlash of 40 um in all. It answers with period 1 at
all four speeds: 5 to 18 Hz is quasi-static against a mesh mode of several kHz, so the teeth stay in contact and follow
the torque.

kv (`dynamic_factors`): the print takes kv = (Fm + k x_2)/Fm, gap included; the factor of the contact force is N/Fm.
With constant linear parameters kv depends on Tm/b alone, so the print's "kv grows with torque" and "kv grows with
backlash" contradict each other wherever it is monotone: the trend with backlash comes out, the one with torque does
not. `engagement`: teeth that carry load under random gaps, over a cycle of the torque; between two starts of teeth
their stiffness is constant, not linear as printed. `picture_kv` and `picture_engagement` draw both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

import gearblocks as gb
from gearblocks.geometry.spline_teeth import deflection_at, engaged_teeth


@dataclass(frozen=True)
class Numbers:
    """SI values of one coupling. b: half of the backlash along the arc; start: static equilibrium at the means."""

    name: str
    inertias: tuple[float, float, float, float]
    k_input: float
    k_output: float
    k_mesh: float
    k_amplitude: float
    damping_shaft: float
    damping_mesh: float
    torque: float
    torque_variation: float
    b: float
    radius: float = 0.025


SET_S = Numbers(
    "spline coupling, set S", (8.459, 3.06, 2.033, 2.543), 109700.0, 22550.0, 245e6, 59.83e6, 0.00591, 0.03189, 2600.0,
    0.8711, 0.396e-3,
)  # fmt: skip
STEEL = Numbers(
    "spline coupling, steel", (1.0e-2, 2.0e-4, 4.0e-4, 8.0e-3), 1.0e5, 8.0e4, 245e6, 59.83e6, 0.03, 0.06, 2600.0, 0.3,
    20e-6,
)  # fmt: skip


def build(rpm: float = 300.0) -> gb.Drivetrain:
    """Set S at a speed in rpm. `speed` [rad/s], `torque` [N m] and `torque_variation` are Parameters."""
    return coupling(SET_S, rpm)


def steel(rpm: float = 300.0) -> gb.Drivetrain:
    """The steel set at a speed in rpm."""
    return coupling(STEEL, rpm)


def period_5() -> gb.Scene:
    """Set S at 360 rpm, where the teeth part in every turn: the largest force of the motion of period 5, to 1 %."""
    return _largest_force(360.0, after=90, turns=100)


def chaos() -> gb.Scene:
    """Set S at 1080 rpm, where no turn is like another: the largest force of a hundred turns, to 1 %."""
    return _largest_force(1080.0, after=100, turns=200)


def _largest_force(rpm: float, after: int, turns: int) -> gb.Scene:
    turn = 60.0 / rpm
    asked = gb.peak("spline.force", after=after * turn)
    return gb.Scene(build(rpm), t_end=turns * turn, quantity=asked, within=0.01, name=f"spline at {rpm:g} rpm")


def coupling(numbers: Numbers, rpm: float) -> gb.Drivetrain:
    """Four discs, two shafts, a spline; torque in and out, both T (1 + eps cos wt), in phase with the stiffness."""
    n = numbers
    rig = gb.Drivetrain(n.name)
    speed = gb.Parameter("speed", gb.rpm(rpm), "rad/s")
    torque = gb.Parameter("torque", n.torque, "N m")
    eps = gb.Parameter("torque_variation", n.torque_variation)
    r = gb.Parameter("radius", n.radius, "m")
    applied = torque * (1 + eps * gb.cos(speed * gb.time))

    twist_in, twist_out = n.torque / n.k_input, n.torque / n.k_output
    arc = (n.torque / n.radius / n.k_mesh + n.b) / n.radius
    angles = (0.0, -twist_in, -twist_in - arc, -twist_in - arc - twist_out)
    names = ("input", "external", "internal", "output")
    discs = [
        rig.add(name, gb.Inertia(J=J, phi0=phi, w0=0.0)) for name, J, phi in zip(names, n.inertias, angles, strict=True)
    ]
    shaft_in = rig.add("shaft_in", gb.Shaft(k=n.k_input, damping_ratio=n.damping_shaft))
    shaft_out = rig.add("shaft_out", gb.Shaft(k=n.k_output, damping_ratio=n.damping_shaft))
    spline = rig.add(
        "spline",
        gb.SplineCoupling(
            teeth=20, radius=r, k=n.k_mesh, damping_ratio=n.damping_mesh,
            stiffness_variation=gb.Fourier(cos=(n.k_amplitude / n.k_mesh,), driven_by=speed),
            backlash=gb.Backlash(half_gap=n.b), contact_damping="always",
        ),
    )  # fmt: skip
    drive = rig.add("drive", gb.Torque(tau=applied))
    load = rig.add("load", gb.Torque(tau=-applied))
    rig.chain(drive, discs[0], shaft_in, discs[1], spline, discs[2], shaft_out, discs[3], load)

    for i, (a, b) in enumerate(pairwise(names), 1):
        rig.coordinate(f"x{i}", r * (gb.sense(f"{a}.phi") - gb.sense(f"{b}.phi")), "m")
        rig.coordinate(f"v{i}", r * (gb.sense(f"{a}.w") - gb.sense(f"{b}.w")), "m/s")
    return rig


# -- dynamic factors and engaged teeth ---------------------------------------------------------------------------------


def dynamic_factors(
    torques: Sequence[float] = (2600.0,), half_gaps: Sequence[float] = (0.396e-3,), rpm: float = 360.0, *, after: int = 300,
    turns: int = 10, rtol: float = 1e-9, numbers: Numbers = SET_S,
) -> gb.Study:  # fmt: skip
    """kv by both definitions over mean torques [N m] and half gaps [m]: the largest of so many turns after the transient.

    A study with one dimension per row: columns "print" (Fm + k x_2)/Fm and "contact" N/Fm.
    """
    turn = 60.0 / rpm
    begin, end = after * turn, (after + turns) * turn
    return gb.sweep(
        coupling(numbers, rpm), {"torque": torques, "spline.backlash.half_gap": half_gaps}, t_end=end,
        quantity=[gb.dynamic_factor("spline", kind, after=begin, before=end) for kind in ("print", "contact")],
        rtol=rtol, initial="static",
    )  # fmt: skip


@dataclass(frozen=True)
class Engagement:
    """Over one cycle of the torque: angles [rad], torque [N m], number of teeth that carry it, deflection [m]."""

    angles: Any
    torque: Any
    teeth: Any
    deflection: Any


def random_gaps(sigma: float = 20e-6, mean: float = 75e-6, teeth: int = 20, seed: int = 0) -> tuple[float, ...]:
    """Gaps of the teeth [m], normally distributed, none below 0."""
    drawn = np.random.default_rng(seed).normal(mean, sigma, teeth)
    return tuple(np.maximum(drawn, 0.0).tolist())


def engagement(
    gaps: Sequence[float], eps: float, *, torque: float = 2600.0, k_tooth: float = 400e6, radius: float = 0.025,
    points: int = 17,
) -> Engagement:  # fmt: skip
    """Engaged teeth under T (1 + eps cos theta); gaps: of each tooth on the drive side [m]; k_tooth: of one pair [N/m]."""
    angles = np.linspace(0.0, 2 * np.pi, points)
    applied = torque * (1 + eps * np.cos(angles))
    forces = [float(T) / radius for T in applied]
    return Engagement(
        angles, applied, np.array([engaged_teeth(F, gaps, k_tooth) for F in forces]),
        np.array([deflection_at(F, gaps, k_tooth) for F in forces]),
    )  # fmt: skip


def picture_kv(path: str | Path) -> None:
    """kv against torque and against backlash at 360 rpm, by both definitions."""
    from matplotlib.figure import Figure

    torques, gaps = np.linspace(1300.0, 5200.0, 14).tolist(), np.linspace(0.1e-3, 0.6e-3, 11).tolist()
    over_torque, over_gap = dynamic_factors(torques), dynamic_factors(half_gaps=gaps)
    figure = Figure(figsize=(8.0, 3.4), layout="constrained")
    named = (
        f"mean torque in N m (half of the backlash: {1e3 * SET_S.b:g} mm)",
        f"half of the backlash in mm ({SET_S.torque:g} N m)",
    )
    over = (torques, over_torque, named[0]), ([1e3 * b for b in gaps], over_gap, named[1])
    for axis, (x, study, label) in zip(figure.subplots(1, 2, sharey=True), over, strict=True):
        values = study.values.reshape(len(x), 2)
        for column, words in enumerate(("print: (Fm + k x)/Fm", "contact: N/Fm")):
            axis.plot(x, values[:, column], "o-", markersize=3, label=words)
        axis.set_xlabel(label)
        axis.grid(visible=True, color="0.9")
        axis.legend(frameon=False)
    figure.axes[0].set_ylabel("dynamic factor kv at 360 rpm")
    figure.savefig(path, dpi=130)


def picture_engagement(path: str | Path, gaps: Sequence[float] | None = None) -> None:
    """Engaged teeth and deflection over a cycle of the torque, for a small and a large variation."""
    from matplotlib.figure import Figure

    row = random_gaps() if gaps is None else gaps
    figure = Figure(figsize=(8.0, 3.4), layout="constrained")
    teeth, deflection = figure.subplots(1, 2)
    for eps in (0.1, 0.5):
        found = engagement(row, eps, points=721)
        for axis, values in ((teeth, found.teeth), (deflection, 1e6 * found.deflection)):
            axis.plot(np.degrees(found.angles), values, label=f"eps = {eps}")
    for axis, words in ((teeth, f"engaged teeth of {len(row)}"), (deflection, "deflection in \N{MICRO SIGN}m")):
        axis.set_xlabel("angle of the torque in deg")
        axis.set_ylabel(words)
        axis.grid(visible=True, color="0.9")
        axis.legend(frameon=False)
    figure.savefig(path, dpi=130)
