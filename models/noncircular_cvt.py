"""Continuously variable transmission of non-circular gears: three branches, a differential each, and selectors.

          pair 1, th + psi_j ------------> left  \
    input                                         differential j -> shaft -> inertia j -> selector j -> output
          pair 2, th + psi_j + delta ----> carrier /                                     (common)    load

Each branch turns at i_out = k delta/2 of the input while both of its pairs are on the straight part of their ratio law
m = k phi + b (differential: right = 2 carrier/i1 - left, i1 = 2), and falls back in the rest of the turn. N = 3
branches, 2 pi/3 apart, take the load in turn; the selectors are clutches or dogs, changed over by one of six `STRATEGIES`.
Timing is what matters: at 60 degrees the shafts that carry the load see 0.37 N m where clutches blend, 0.38 where they or dogs
change over anywhere in the overlap, and 0.765 where they do so 15 degrees late and the old branch is already falling back
(`picture`). A phase that leaves no overlap cannot blend, one that leaves a gap is refused (`matching`).

J. Chongqing Univ. vol. 45. Reproduced: kinematics, the even windows, rigid pairs and differentials, the selectors. Not
reproduced: Table 1, taken literally, is no pair of gears (`design(0.7, 0.5)` says why); NORM, whose numbers are the law's
shape over 240 degrees, stands for it, and its pitch curves are partly concave. Shafts, inertias, capacities and a = 2, i1 = 2,
i2 = 1 are chosen: the paper gives none.

Law: NORM, m = 0.7 phi/X + 0.5 on X = 240 degrees, closed over a turn. A phase of delta = 0 is geared neutral: the
output rests. Angles of the input count from 0; its position over the laws at the start is the middle of the window of
branch 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import gearblocks as gb

X = math.radians(240)
LINE = 0.7 / X, 0.5  # k in 1/rad, b
LAW = gb.RatioLaw.segments(*LINE, X)
BRANCHES, SPEED, LOAD, CAPACITY = 3, 262.0, 0.2, 1.0  # -, rad/s, N m, N m
J_BRANCH, J_OUTPUT, K_SHAFT, C_SHAFT = 2.0e-6, 2.0e-5, 100.0, 0.005  # kg m2, kg m2, N m/rad, N m s/rad
STRATEGIES = ("blend", "inst_mid", "inst_end", "inst_late", "dog_end", "dog_late")
"""Change-over from branch to branch: capacities that ramp over each other; clutches that switch at the middle, at the end or
15 degrees after the end of the overlap; dogs at its end or 15 degrees after it, the old one out first."""
LATE, FREE = math.radians(15), 2


def build() -> gb.Drivetrain:
    """60 degrees of phase: clutches that overlap, the new one closing before the old one opens."""
    return selected(math.radians(60))


def changing_over() -> gb.Scene:
    """60 degrees of phase, from the second turn on: peak torque of a branch's shaft and heat of its clutch, to 1 %."""
    turn = math.tau / SPEED
    asked = gb.peak("shaft_0.torque", after=turn), gb.energy_lost("selector_0", after=turn)
    return gb.Scene(build(), t_end=3 * turn, quantity=asked, within=0.01, name="CVT at 60 degrees")


def dogs() -> gb.Drivetrain:
    """120 degrees of phase, no overlap left: dogs that change over at the end of each window."""
    return selected(math.radians(120), "dog_end")


def neutral() -> gb.Drivetrain:
    """No phase: geared neutral, the output rests while all branches swing."""
    return selected(0.0)


def late() -> gb.Drivetrain:
    """60 degrees of phase, clutches that change over 15 degrees after the overlap: the old branch drags the output."""
    return selected(math.radians(60), "inst_late")


def selected(delta: float, strategy: str = "blend") -> gb.Drivetrain:
    """The transmission at the phase delta [rad] of its second pairs, changed over by one of `STRATEGIES`."""
    _check(delta, strategy)
    rig = gb.Drivetrain(f"CVT, {math.degrees(delta):.0f} degrees, {strategy}")
    middle = (X - delta) / 2
    angle = SPEED * gb.time + middle
    source = rig.add("input", gb.Speed(w=SPEED))
    output = rig.add("output", gb.Inertia(J=J_OUTPUT, w0=_branch_speed(middle, delta)))
    rig.connect(rig.add("load", gb.Torque(tau=-LOAD)).flange, output.b)
    for j in range(BRANCHES):
        own = middle - math.tau * j / BRANCHES
        pairs = [
            rig.add(f"pair{i}_{j}", gb.NonCircularGear(law=LAW, external=False, phase=own + (i - 1) * delta))
            for i in (1, 2)
        ]
        differential = rig.add(f"differential_{j}", gb.Differential(ratio=2))
        rig.connect(source.flange, *(pair.a for pair in pairs))
        rig.connect(pairs[0].b, differential.left)
        rig.connect(pairs[1].b, differential.carrier)
        wound = -LOAD / K_SHAFT if j == 0 else 0.0
        branch = rig.add(f"branch_{j}", gb.Inertia(J=J_BRANCH, phi0=wound, w0=_branch_speed(own, delta)))
        shaft = rig.add(f"shaft_{j}", gb.Shaft(k=K_SHAFT, c=C_SHAFT))
        rig.connect(differential.right, shaft.a)
        rig.connect(shaft.b, branch.a)
        rig.add(f"selector_{j}", _selector(j, delta, strategy, angle))
        selector = rig[f"selector_{j}"]
        rig.connect(branch.b, selector.a)
        rig.connect(selector.b, output.a)
    return rig


def _branch_speed(angle: float, delta: float) -> float:
    """Speed of a branch at the angle of its first pair."""
    return SPEED * float(LAW.m(angle + delta) - LAW.m(angle))


def _window(j: int, delta: float) -> tuple[float, float, float]:
    """Angles of the input where the window of branch j begins and ends, and how far it overlaps its neighbours'."""
    pitch = math.tau / BRANCHES
    return pitch * j + max(0.0, -delta), pitch * j + X - max(0.0, delta), X - abs(delta) - pitch


def _check(delta: float, strategy: str) -> None:
    """Refuses a strategy that is none, or that this phase leaves no room for."""
    overlap = _window(0, delta)[2]
    if strategy not in STRATEGIES:
        raise gb.ParameterError(f"strategy = {strategy!r} must be one of {', '.join(STRATEGIES)}")
    if overlap < -1e-12 or (strategy == "blend" and overlap <= 1e-12):
        raise gb.ParameterError(
            f"strategy = {strategy!r} at delta = {math.degrees(delta):g} deg: the windows of two branches overlap by "
            f"{math.degrees(overlap):.3g} deg; blending needs more than 0, any change without a gap 0. A smaller phase, more "
            "branches or a longer working segment makes room (see `matching`)"
        )


def _selector(j: int, delta: float, strategy: str, angle: Any) -> gb.Block:
    """The clutch or dog between branch j and the output."""
    if strategy == "blend":
        return gb.Clutch(capacity=CAPACITY * _ramp(j, delta, angle))
    _, end, overlap = _window(0, delta)
    change = end + {"mid": -overlap / 2, "end": 0.0, "late": LATE}[strategy.partition("_")[2]]
    times = [math.tau * i / BRANCHES + change for i in range(-1, BRANCHES)]
    turns = gb.Table(times, [float(i == j) for i in range(BRANCHES)] + [float(j == 0)], kind="step", periodic=True)
    return (
        gb.DogClutch(engaged=turns(angle))
        if strategy.startswith("dog")
        else gb.Clutch(capacity=CAPACITY * turns(angle))
    )


def _ramp(j: int, delta: float, angle: Any) -> Any:
    """Share of the capacity: up in the second quarter of the overlap, down in the third one of the next.

    A ramp over u = 0 .. 1 is 3 u^2 - 2 u^3.
    """
    begin, end, overlap = _window(j, delta)
    up, down = begin + overlap / 4, end - overlap / 2
    corners = [up, up + overlap / 4, down, down + overlap / 4, up + math.tau]
    u = gb.Table(corners, [0, 1, 1, 0, 0], periodic=True)(angle)
    return 3 * u**2 - 2 * u**3


# -- design ------------------------------------------------------------------------------------------------------------


def i_out(delta: float, k: float = LINE[0], i2: float = 1.0, a: float = 2.0) -> float:
    """Ratio output over input in the window: k delta/(i2 (a - 1)), where a i2 = i1 for two pairs of one law."""
    return k * delta / (i2 * (a - 1))


@dataclass(frozen=True)
class Matching:
    """What N branches of a working segment X [rad] allow. least: the X [rad] that a phase needs; most: the phase [rad] that
    this X allows; zeta: branches in their even window on average: < 1 a gap (ripple), 1 no buffer, > 1 a buffer."""

    branches: int
    segment: float
    phase: float

    @property
    def zeta(self) -> float:
        """N (X - abs(delta))/360 deg."""
        return self.branches * (self.segment - abs(self.phase)) / math.tau

    @property
    def least(self) -> float:
        """360 deg/N + abs(delta)."""
        return math.tau / self.branches + abs(self.phase)

    @property
    def most(self) -> float:
        """X - 360 deg/N; below 0: none."""
        return self.segment - math.tau / self.branches

    @property
    def verdict(self) -> str:
        """In a word."""
        even = math.isclose(self.zeta, 1.0, rel_tol=1e-12)
        return "no buffer" if even else "gap" if self.zeta < 1 else "buffer"


def matching(branches: int = BRANCHES, segment: float = X, phase: float = 0.0) -> Matching:
    """Whether N branches with a working segment X hold the ratio at a phase delta."""
    return Matching(branches, segment, phase)


def design(k: float = LINE[0], b: float = LINE[1], segment: float = X) -> gb.RatioDesign:
    """The law m = k phi + b on [0, X] at a centre distance of 200 mm, with what a designer asks, or the refusal.

    `design(0.7, 0.5)` is Table 1 of the paper taken literally: refused with the reason and the largest feasible X, 103.53 deg.
    """
    return gb.design_ratio(k, b, segment, E=0.2)


def branch_ratio(j: int, angle: Any, delta: float) -> Any:
    """Ratio of branch j over the input where the input stands at an angle [rad], numbers or rows of them."""
    own = angle - math.tau * j / BRANCHES
    return LAW.m(own + delta) - LAW.m(own)


# -- why timing matters ------------------------------------------------------------------------------------------------


def engaged_torque(run: gb.Trajectory) -> Any:
    """The largest torque [N m] of any branch's shaft while its selector is not free, at each instant of a run."""
    rows = [abs(run[f"shaft_{j}.torque"]) * (run[f"selector_{j}.mode"] != FREE) for j in range(BRANCHES)]
    return np.max(rows, axis=0)


def picture(path: str | Path, delta: float = math.radians(60)) -> None:
    """Torque of the engaged shafts and speed of the output by strategy, over the input's angle past a change-over."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 7.0), layout="constrained")
    axes = figure.subplots(len(STRATEGIES), 2, sharex=True, sharey="col")
    begin = (X - delta) / 2
    for (left, right), strategy in zip(axes, STRATEGIES, strict=True):
        try:
            run = gb.simulate(selected(delta, strategy), t_end=0.06, rtol=1e-9)
        except gb.ParameterError:
            left.set_title(f"{strategy}: no overlap", fontsize=8, loc="left")
            continue
        angle, torque = np.degrees(begin + SPEED * run.t), engaged_torque(run)
        left.plot(angle, torque, linewidth=0.9)
        left.set_title(f"{strategy}: {torque.max():.3f} N m at most", fontsize=8, loc="left")
        right.plot(angle, run["output.w"], linewidth=0.9, color="#D55E00", label="speed")
        left.set_xlim(360, 720)
        right.axhline(SPEED * i_out(delta), color="0.6", linewidth=0.7, label="even speed, k delta of the input's")
        for j in range(2 * BRANCHES + 1):
            end = np.degrees(_window(j, delta)[1])
            for axis in (left, right):
                axis.axvspan(
                    end - np.degrees(_window(0, delta)[2]), end, color="0.92", linewidth=0, label="both windows open"
                )
    for axis in axes[-1]:
        axis.set_xlabel("angle of the input in deg")
    for column, words in enumerate(("torque of the engaged shafts in N m", "speed of the output in rad/s")):
        axes[len(STRATEGIES) // 2][column].set_ylabel(words)
    listed = {words: handle for row in axes for handle, words in zip(*row[1].get_legend_handles_labels(), strict=True)}
    figure.legend(
        [*listed.values()], [*listed], loc="outside upper right", ncols=len(listed), fontsize=8, frameon=False
    )
    figure.savefig(path, dpi=130)
