"""Start values are declared by role: what a block calls w0, v0 or phi0 and reads is a parameter like any other."""

import re

import numpy as np
import pytest

import gearblocks as gb


class Flywheel(gb.Block):
    """A body that a viscous drag w0, a torque v0 and a spring to the angle phi0 act on: parameters with unlucky names."""

    a = gb.Flange("shaft")
    J: float = gb.param("moment of inertia", "kg m2", gt=0)
    w0: float = gb.param("drag", "N m s/rad")
    v0: float = gb.param("torque", "N m", default=0.0)
    phi0: float = gb.param("rest angle", "rad", default=0.0)
    s0: float | None = gb.param("stiffness", "N m/rad", default=None)

    def physics(self, s):
        yield gb.Body(s.a, s.J)
        yield gb.Acts(s.a, s.v0 - s.w0 * s.a.w)
        if self.s0 is not None:
            yield gb.Potential(s.s0 * (s.a.phi - s.phi0) ** 2 / 2)
        yield gb.Shows("drag", s.w0, "N m s/rad")


class Disc(gb.Block):
    """A body with start values under names of its own."""

    a = gb.Flange("shaft")
    J: float = gb.param("moment of inertia", "kg m2", gt=0)
    begin: float | None = gb.param("start angle", "rad", default=None, start="angle")
    running: float | None = gb.param("start speed", "rad/s", default=None, start="speed")

    def physics(self, s):
        yield gb.Body(s.a, s.J)


def _alone(block: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("rig")
    rig.connect(rig.add("wheel", block).a, rig.add("nothing", gb.Torque(tau=0.0)).flange)
    return rig


T = np.linspace(0.0, 1.0, 5)


class Plain(gb.Block):
    """A body written as in the catalogue, before start values had a role."""

    a = gb.Flange("shaft")
    J: float = gb.param("moment of inertia", "kg m2", gt=0)
    phi0: float = gb.param("start angle", "rad", default=0.5)
    w0: float = gb.param("start speed", "rad/s", default=3.0)

    def physics(self, s):
        """w0 in a text says nothing."""
        yield gb.Body(s.a, s.J)


def _drag(s):
    return -s.w0 * s.a.w


class Outside(gb.Block):
    """A function beside the class reads w0."""

    a = gb.Flange("shaft")
    J: float = gb.param("moment of inertia", "kg m2", gt=0)
    w0: float = gb.param("drag", "N m s/rad", default=0.5)

    def physics(self, s):
        yield gb.Body(s.a, s.J)
        yield gb.Acts(s.a, _drag(s))


def test_a_number_that_a_function_beside_the_block_reads_is_a_parameter() -> None:
    run = gb.simulate(_alone(Outside(J=2.0)), t=T, initial={"wheel.w": 3.0}, rtol=1e-11)
    np.testing.assert_allclose(run["wheel.a.w"], 3.0 * np.exp(-0.25 * T), rtol=1e-9)


class Half(gb.Block):
    """One start value, and a method beside physics that reads the other name."""

    a = gb.Flange("shaft")
    J: float = gb.param("moment of inertia", "kg m2", gt=0)
    w0: float = gb.param("start speed", "rad/s", default=3.0)
    phi0: float = gb.param("rest angle", "rad", default=0.5)

    def _torque(self, s):
        return -s.J * (s.a.phi - s.phi0)

    def physics(self, s):
        yield gb.Body(s.a, s.J)
        yield gb.Acts(s.a, self._torque(s))


@pytest.mark.long
def test_a_number_called_as_in_the_catalogue_that_nothing_reads_is_a_start_value() -> None:
    model = gb.build(_alone(Plain(J=1.0)))
    run = gb.simulate(model, t_end=0.1)
    assert (run["wheel.a.phi"][0], run["wheel.a.w"][0]) == (0.5, 3.0)
    assert gb.simulate(model, t_end=0.1, parameters={"wheel.w0": 7.0})["wheel.a.w"][0] == 7.0
    assert {"wheel.phi0", "wheel.w0"} <= {p.path for p in model.program.parameters}
    run = gb.simulate(_alone(Half(J=1.0)), t=T, rtol=1e-11)
    np.testing.assert_allclose(run["wheel.a.phi"], 0.5 - 0.5 * np.cos(T) + 3.0 * np.sin(T), rtol=1e-9, atol=1e-10)


def test_a_body_with_a_parameter_called_w0_runs_and_the_parameter_is_tunable() -> None:
    model = gb.build(_alone(Flywheel(J=2.0, w0=1.5, v0=0.5)))
    for drag, torque in ((1.5, 0.5), (0.3, -2.0)):
        run = gb.simulate(
            model, t=T, parameters={"wheel.w0": drag, "wheel.v0": torque}, initial={"wheel.w": 3.0}, rtol=1e-11
        )
        exact = torque / drag + (3.0 - torque / drag) * np.exp(-drag * T / 2.0)
        np.testing.assert_allclose(run["wheel.a.w"], exact, rtol=1e-9)
        assert run["wheel.drag"][0] == drag
    tunable = {p.path: p.tunable for p in model.program.parameters}
    assert tunable["wheel.w0"] and tunable["wheel.v0"] and tunable["wheel.phi0"]
    assert tunable["wheel.a.w0"] is False and len(tunable) == len(model.program.parameters)


def test_a_body_with_a_parameter_called_phi0_keeps_it_beside_its_start_angle() -> None:
    rig = _alone(Flywheel(J=1.0, w0=0.0, phi0=0.25, s0=4.0))
    run = gb.simulate(rig, t=T, initial={"wheel.phi": 1.25}, rtol=1e-11)
    np.testing.assert_allclose(run["wheel.a.phi"], 0.25 + np.cos(2.0 * T), rtol=1e-9)
    moved = gb.simulate(rig.set({"wheel.phi0": 1.25}), t=T, initial={"wheel.phi": 1.25}, rtol=1e-11)
    np.testing.assert_allclose(moved["wheel.a.phi"], 1.25, rtol=1e-12)


@pytest.mark.long
def test_tied_to_an_inertia_the_start_values_are_those_of_the_inertia() -> None:
    rig = gb.Drivetrain("rig")
    wheel = rig.add("wheel", Flywheel(J=1.0, w0=0.0))
    rig.connect(wheel.a, rig.add("body", gb.Inertia(J=1.0, w0=7.0)).a)
    assert gb.simulate(rig, t_end=0.1)["wheel.a.w"][-1] == 7.0


def test_a_mass_of_ones_own_with_a_parameter_called_v0_slides() -> None:
    class Sled(gb.Block):
        a = gb.Flange("sled", slider=True)
        m: float = gb.param("mass", "kg")
        v0: float = gb.param("drag", "N s/m")
        s0: gb.State = gb.State("distance", "m", start=2.0)

        def physics(self, s):
            yield gb.Body(s.a, s.m)
            yield gb.Acts(s.a, -s.v0 * s.a.v)
            yield gb.Rate(s.s0, s.a.v)
            yield gb.Shows("distance", s.s0, "m")

    rig = gb.Drivetrain("rig")
    rig.connect(rig.add("sled", Sled(m=1.0, v0=2.0)).a, rig.add("push", gb.Force(f=0.0)).flange)
    run = gb.simulate(rig, t=T, initial={"sled.v": 4.0}, rtol=1e-11)
    np.testing.assert_allclose(run["sled.distance"], 2.0 + 2.0 * (1 - np.exp(-2.0 * T)), rtol=1e-9)


@pytest.mark.long
def test_declared_start_values_are_start_values_whatever_their_names() -> None:
    model = gb.build(_alone(Disc(J=1.0, begin=0.5, running=3.0)))
    run = gb.simulate(model, t=T)
    np.testing.assert_allclose(run["wheel.a.phi"], 0.5 + 3.0 * T, rtol=1e-12)
    tunable = {p.path: p.tunable for p in model.program.parameters}
    assert tunable["wheel.begin"] is False and tunable["wheel.running"] is False
    shared = gb.simulate(_alone(Disc(J=1.0, running=gb.Parameter("speed", 2.0))), t=T, parameters={"speed": 4.0})
    assert shared["wheel.a.w"][0] == 4.0


def test_declared_start_values_that_contradict_each_other_are_named_by_their_fields() -> None:
    rig = gb.Drivetrain("rig")
    ends = [rig.add(name, Disc(J=1.0, running=w)).a for name, w in (("one", 1.0), ("two", 2.0))]
    rig.connect(*ends)
    with pytest.raises(gb.ModelError, match=r"'one': running = 1.0 and 'two': running = 2.0 contradict"):
        gb.build(rig)
    held = gb.Drivetrain("held")
    held.connect(held.add("disc", Disc(J=1.0, running=2.0)).a, held.add("ground", gb.Fixed()).flange)
    with pytest.raises(gb.ModelError, match=r"'disc': running = 2.0 rad/s, but a Fixed holds .*; leave running out"):
        gb.build(held)


def test_a_law_that_reads_a_start_value_of_its_body_is_refused() -> None:
    class Wound(Disc):
        def physics(self, s):
            yield gb.Body(s.a, s.J)
            yield gb.Acts(s.a, -s.begin * s.a.w)

    with pytest.raises(gb.ModelError, match=re.escape("Wound 'wheel': the physics reads the start value 'begin'")):
        gb.build(_alone(Wound(J=1.0, begin=0.5)))


@pytest.mark.long
def test_a_ground_of_ones_own_holds_a_declared_start_angle() -> None:
    class Wall(gb.Block):
        flange = gb.Flange("wall")
        tilt: float = gb.param("angle at which it holds", "rad", default=0.0, start="angle")

        def physics(self, s):
            yield gb.Tie(s.flange.phi - s.tilt)

    rig = gb.Drivetrain("rig")
    wall, shaft = rig.add("wall", Wall(tilt=0.5)), rig.add("shaft", gb.Shaft(k=9.0))
    rig.chain(wall, shaft, rig.add("body", gb.Inertia(J=1.0, phi0=0.5)))
    assert np.abs(gb.simulate(rig, t_end=1.0)["body.w"]).max() < 1e-12
    moved = gb.simulate(rig, t=T, parameters={"wall.tilt": 0.25}, rtol=1e-11)
    np.testing.assert_allclose(moved["body.phi"], 0.25 + 0.25 * np.cos(3.0 * T), rtol=1e-9)


def _declare(**members: object) -> None:
    type("Wrong", (gb.Block,), members)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: gb.param("start angle", "rad", start="angel"), "start = 'angel' must be 'angle' or 'speed'"),
        (lambda: gb.param("start angles", "rad", many=True, start="angle"), "of one number"),
        (lambda: _declare(p=gb.param("p", start="angle"), q=gb.param("q", start="angle")), "p (angle), q (angle)"),
        (lambda: type("Odd", (gb.Effect,), {"w": gb.param("w", start="speed")}), "Odd.w: an effect has no start"),
    ],
)
def test_declarations_that_mean_nothing_are_refused(make, words) -> None:
    with pytest.raises(gb.ModelError, match=re.escape(words)):
        make()


def test_an_option_called_rigid_stays_as_it_is_when_compliance_goes() -> None:
    class Coupling(gb.Block):
        a, b = gb.Flange("left"), gb.Flange("right")
        k: float | None = gb.param("stiffness", "N m/rad", default=None, belongs_to="compliance")
        rigid: bool = gb.option("bolted, not clamped", default=False)

        def physics(self, s):
            if self.k is None:
                yield gb.Tie(s.a.phi - s.b.phi)
            else:
                yield gb.Force(s.b.phi - s.a.phi, s.k * (s.b.phi - s.a.phi))

    rig = gb.Drivetrain("rig")
    rig.chain(rig.add("one", gb.Inertia(J=1.0)), rig.add("c", Coupling(k=1.0)), rig.add("two", gb.Inertia(J=1.0)))
    assert rig.without("c.compliance")["c"].rigid is False
    rig = rig.set({"c": gb.Shaft(k=1.0)})
    assert rig.without("c.compliance")["c"].rigid is True
