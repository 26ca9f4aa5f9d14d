"""What a stage or a tool returns says in one screen what it is; the whole content stands in its attributes."""

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import gearblocks as gb
from gearblocks.analysis.reduction import reduction
from gearblocks.assembly.assemble import assemble
from gearblocks.solver.kinematics import kinematics
from gearblocks.solver.point import opened

SCREEN = 2000  # characters, and 25 lines


def _built(name: str) -> gb.Drivetrain:
    """The train of a file of models/."""
    spec = importlib.util.spec_from_file_location(f"{name}_model", Path(__file__).parents[2] / "models" / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    made = module.build()
    assert isinstance(made, gb.Drivetrain)
    return made


def _stages(train: gb.Drivetrain, model: gb.Model) -> Iterator[Any]:
    yield from (train, train.tree(), train.train(), assemble(train.train()), train.equations(), model, model.library)
    run = gb.simulate(model, t_end=0.01)
    yield from (run, run.content(), run.energy, run.stats, run.final_state)


def _inside_the_solver(model: gb.Model) -> Iterator[Any]:
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        sim.inputs[:] = [x.start for x in model.program.inputs]
        with opened(sim, model.program, 0.0) as point:
            yield from (
                sim,
                point,
                kinematics(point),
                sim.constraints(),
                point.constraints(),
                reduction(point, model.program.n),
            )
            yield sim.step_matrix(0.0, point.y, 1e-3)


def _answers(model: gb.Model, load: str) -> Iterator[Any]:
    output = next(q.name for q in model.program.outputs if q.name.endswith(".w"))
    yield gb.linearize(model, None)
    yield gb.modes(model, None)
    yield gb.frequency_response(model, load, output, [1.0, 2.0], at=None)


@pytest.mark.long
@pytest.mark.parametrize(
    ("module", "load"),
    [("automatic_gearbox", "wheels.J"), pytest.param("stiff_chain", "disc0.J", marks=pytest.mark.long)],
)
def test_the_repr_of_a_long_train_fits_a_screen(module: str, load: str) -> None:
    train = _built(module)
    model = gb.build(train)
    for things in (_stages(train, model), _inside_the_solver(model), _answers(model, load)):
        for thing in things:
            words = repr(thing)
            assert len(words) < SCREEN and words.count("\n") < 25, f"{type(thing).__name__}: {words[:200]}"


def test_a_repr_says_what_and_how_many() -> None:
    train = gb.Drivetrain("pair")
    a, b = train.add("a", gb.Inertia(J=1.0)), train.add("b", gb.Inertia(J=2.0, w0=3.0))
    train.chain(a, train.add("shaft", gb.Shaft(k=5.0)), b)
    model = gb.build(train)
    assert repr(train.train()) == "<Train 'pair': 3 components, 4 nodes>"
    assert repr(model).startswith("<Model 'pair': 3 states, ")
    assert repr(gb.modes(model, None)) == "<Modes of 'pair': 2 modes, 1 of them free rotation, 0 .. 0.435864 Hz>"
    assert repr(gb.linearize(model, None)).startswith("<Linearization of 'pair' at t = 0 s: 3 states, 0 inputs, ")
    diagram = gb.campbell(model, "a.w", [1.0, 2.0], orders={"first": 1.0}, at=None)
    assert repr(diagram) == "<Campbell of 'pair' over a.w: 2 speeds, 1 mode, 1 order, 0 crossings>"


def test_the_points_of_a_section_and_its_label_fit_a_screen() -> None:
    train = gb.Drivetrain("swing")
    speed = gb.Parameter("speed", 2.0, "rad/s")
    drive = train.add("drive", gb.Torque(tau=gb.sin(speed * gb.time)))
    body, wall = train.add("body", gb.Inertia(J=1.0)), train.add("wall", gb.Fixed())
    train.connect(drive.flange, body.a)
    train.chain(body, train.add("shaft", gb.Shaft(k=9.0, c=1.0)), wall)
    model = gb.build(train)
    points = gb.poincare(model, gb.stroboscopic("speed"), transient=20, keep=40, rtol=1e-6)
    assert repr(points).startswith("<Points of 'swing': 40 from t = 62.8319 s: shaft.twist, ")
    assert len(repr(gb.classify(model, gb.stroboscopic("speed"), transient=20, keep=40))) < SCREEN
