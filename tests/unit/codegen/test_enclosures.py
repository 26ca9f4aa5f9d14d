"""Which event functions of a program are enclosed, and the polynomials that their arguments are."""

import re
from fractions import Fraction
from math import comb
from pathlib import Path

import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.assembly.assemble import assemble
from gearblocks.codegen.generate import generate
from gearblocks.laws.functions import InverseInvolute

CORE = Path(__file__).parents[3] / "gearblocks" / "solver" / "c"
FLYWHEEL = ("a", gb.Inertia(J=1.0))


class Cam(gb.Block):
    """A torque in a window of the angle."""

    a = gb.Flange("shaft")
    begin: float = gb.param("begin of the window", "rad")

    def physics(self, s):
        yield gb.Acts(s.a, sp.Piecewise((1, sp.cos(s.a.phi) > s.begin), (0, True)))


class Unknown(gb.Block):
    """A condition whose function has no enclosure."""

    a = gb.Flange("shaft")

    def physics(self, s):
        yield gb.Acts(s.a, sp.Piecewise((1, InverseInvolute(s.a.phi**2 + 1) > 1), (0, True)))


def source(*chains):
    """The C text of a train made of chains."""
    rig = gb.Drivetrain("x")
    for chain in chains:
        rig.chain(*(rig.add(name, block) for name, block in chain))
    return generate(assemble(rig.train())).source


def flags(text):
    """is_enclosed of a program, None where it has no enclosures."""
    found = re.search(r"is_enclosed\[\] = \{(.*?)\}", text)
    return None if found is None else [int(x) for x in found[1].split(",")]


def test_a_train_whose_event_functions_are_affine_has_no_enclosures():
    gap = [("gap", gb.Lash(half_gap=0.01, k=1e3)), ("b", gb.Inertia(J=1.0))]
    text = source([("t", gb.Torque(tau=1.0)), FLYWHEEL, *gap])
    assert flags(text) is None
    assert "gb_enclosure" not in text


def test_conditions_over_angles_time_and_sensed_torques_are_enclosed():
    angle = gb.piecewise((1, gb.sin(gb.sense("a.phi") + gb.time) > 0.5), (0, True))
    twist = gb.piecewise((1, gb.sense("k.torque") * gb.cos(gb.sense("b.phi")) > gb.Input("level")), (0, True))
    shaft = [("k", gb.Shaft(k=1e3)), ("b", gb.Inertia(J=2.0)), ("cam", Cam(begin=0.9))]
    text = source(
        [("t", gb.Torque(tau=angle)), FLYWHEEL, *shaft], [("u", gb.Torque(tau=twist)), ("c", gb.Inertia(J=1.0))]
    )
    assert flags(text) == [1, 1, 1]


def test_a_function_without_enclosure_leaves_its_event_function_to_samples():
    text = source([("one", Unknown()), FLYWHEEL, ("two", Cam(begin=0.5))])
    assert sorted(flags(text)) == [0, 1]


def test_constraint_forces_are_enclosed_where_torques_give_them_by_constant_numbers():
    def held(*parts):
        return "force_enclosures" in source([("t", gb.Torque(tau=gb.sin(gb.time))), FLYWHEEL, *parts])

    geared = [("g", gb.IdealGear(ratio=3.0)), ("b", gb.Inertia(J=1.0))]
    assert held(("brake", gb.Brake(capacity=2.0)))
    assert held(*geared, ("clutch", gb.Clutch(capacity=2.0)), ("c", gb.Inertia(J=1)))
    assert not held(("g", gb.LossyGear(ratio=3.0, efficiency=(0.9, 0.9))), ("b", gb.Inertia(J=1.0)))
    assert not held(("j", gb.UniversalJoint(angle=0.4)), ("b", gb.Inertia(J=1.0)), ("brake", gb.Brake(capacity=2.0)))


class Strange(gb.Block):
    """A torque whose function has no enclosure."""

    a = gb.Flange("shaft")

    def physics(self, s):
        yield gb.Acts(s.a, -InverseInvolute(s.a.phi**2 + 1))


@pytest.mark.parametrize(
    "held",
    [
        ("brake", gb.Brake(capacity=2.0)),
        ("bearing", gb.BearingFriction(coulomb=2.0)),
        ("brake", gb.Brake(capacity=2.0, peak=1.2)),
    ],
    ids=["brake", "bearing", "brake with a peak"],
)
@pytest.mark.few(1)
def test_feedback_of_forces_that_are_not_all_enclosed_leaves_no_trace(held):
    """Its functions were left over, without the header of what they are made of: a legal train that did not compile."""
    rig = gb.Drivetrain("x")
    rig.chain(*(rig.add(name, block) for name, block in [("strange", Strange()), FLYWHEEL, held]))
    rig.chain(
        rig.add("t", gb.Torque(tau=2 * gb.sense("k.torque"))), rig.add("b", gb.Inertia(J=1.0, w0=1.0)),
        rig.add("k", gb.Shaft(k=1e3)), rig.add("c", gb.Inertia(J=1.0)),
    )  # fmt: skip
    model = gb.build(rig)
    assert "enclosure" not in model.program.source
    assert gb.simulate(model, t_end=0.01).complete


def test_polynomials_are_fitted_by_the_inverse_of_the_bernstein_matrix():
    text = (CORE / "gb_panel.c").read_text(encoding="utf-8")
    blocks = dict(re.findall(r"double (points|fit)\[[^=]*= \{(.*?)\};", text, re.S))
    points = [Fraction(x) for x in re.findall(r"-?[\d.]+", blocks["points"])]
    fit = [float(x) for x in re.findall(r"-?[\d.]+", blocks["fit"])]
    assert len(set(points)) == len(points) == 13
    nodes = [sp.Rational(x.numerator, x.denominator) for x in points[:9]]
    inverse = sp.Matrix(9, 9, lambda i, k: comb(8, k) * nodes[i] ** k * (1 - nodes[i]) ** (8 - k)).inv()
    for row in range(1, 5):
        for column in range(9):
            assert fit[(row - 1) * 9 + column] == float(inverse[row, column])
            assert inverse[8 - row, 8 - column] == inverse[row, column], "what is read backwards"
