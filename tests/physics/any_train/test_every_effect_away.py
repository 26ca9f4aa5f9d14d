"""Each effect, each element's group and random sets taken away: the rest builds, starts where the full train starts, and runs,
or it is said by name why not."""

import importlib
import re
from random import Random

import pytest

import gearblocks as gb
from tests.random.description import arguments, build
from tests.random.families import FAMILIES, draw

# what is drawn may watch what went, and leave its tables
pytestmark = [
    pytest.mark.filterwarnings("ignore:.*would have acted"),
    pytest.mark.filterwarnings("ignore:.*is left first at"),
]
SHIPPED = {
    "automatic_gearbox": ("build",),
    "dual_clutch": ("build",),
    "limited_slip_differential": ("build", "unlocked"),
    "modelica_examples": (
        "build", "first_grounded", "elastic_bearing", "rolling_wheel", "coupled_clutches", "one_way_clutch",
        "simple_gear_shift", "lossy_gear",
    ),
    "noncircular_cvt": ("build", "dogs", "neutral"),
    "noncircular_planetary": ("build",),
    "planetary_backlash": ("build",),
    "planetary_sets": ("compound", "simpson", "ravigneaux"),
    "spline_coupling": ("build", "steel"),
}  # fmt: skip
# rigid loops, what two fixed things hold, a signal that senses what went, and a start acceleration that the effect made:
# said of the train, with the names of its parts
NAMED = re.compile(
    r"ties of '.*' contradict|prescribes the motion of a shaft that '.*' holds|cannot be fed back"
    r"|prescribes a motion between shafts that are tied rigidly|a(lpha)?0 = .*, but its acceleration at the start is"
)

# what lost the damping that told the speed of a shaft without inertia between two gaps
UNTOLD = re.compile(r"nothing tells how fast its side . turns, a shaft without inertia")


def _sets(rig, random, most):
    """Single effects, those of each element, random sets, all."""
    effects = list(rig.effects())
    if not effects:
        return
    groups = sorted({f"{name.rpartition('.')[0]}.*" for name in effects})
    found = [(e,) for e in effects] + [(g,) for g in groups]
    found += [tuple(random.sample(effects, random.randint(1, len(effects)))) for _ in range(4)]
    yield from random.sample(found, min(most, len(found)))
    yield ("*",)


def _leave_out(rig, random, most=10**6, t_end=2e-3, **given):
    full = gb.build(rig)
    seen = set()
    for gone in _sets(rig, random, most):
        lean = rig.without(*gone)
        if (left := tuple(lean.effects())) in seen:
            continue
        seen.add(left)
        try:
            model = gb.build(lean)
        except gb.ModelError as error:
            if NAMED.search(str(error)):
                continue
            raise
        inputs = {k: x for k, x in given.get("inputs", {}).items() if k in model.program.input_numbers}
        try:
            start = gb.carried_start(full, model, initial=given.get("initial"), inputs=inputs)
            run = gb.simulate(model, t_end=t_end, initial=start, inputs=inputs)
        except gb.SimulationError as error:
            if UNTOLD.search(str(error)):
                continue
            raise
        assert run.complete, gone
        states = " ".join(x.name for x in model.program.states) + " ".join(x.path for x in model.program.parameters)
        for name in lean.dropped:
            path, _, effect = name.rpartition(".")
            assert f"{path}.{effect}." not in states, f"{gone}: a trace of {name}"


@pytest.mark.long
def test_every_effect_of_the_gearbox_and_of_the_axle_can_go():
    for module, function in (("automatic_gearbox", "build"), ("limited_slip_differential", "build")):
        _leave_out(getattr(importlib.import_module(f"models.{module}"), function)(), Random(1))


@pytest.mark.long
def test_every_effect_of_the_spline_coupling_can_go():
    _leave_out(importlib.import_module("models.spline_coupling").build(), Random(2), most=8)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.few(1)
def test_effects_of_a_drawn_train_can_go(family):
    train = draw(family, 1)
    _leave_out(build(train, gb), Random(3), most=1, **arguments(train, gb))


@pytest.mark.long
@pytest.mark.parametrize(("module", "function"), [(m, f) for m, functions in SHIPPED.items() for f in functions])
def test_effects_of_shipped_trains_can_go(module, function):
    _leave_out(getattr(importlib.import_module(f"models.{module}"), function)(), Random(4), most=40)


@pytest.mark.long
@pytest.mark.parametrize("family", FAMILIES)
def test_effects_of_more_drawn_trains_can_go(family):
    for seed in range(2, 14):
        train = draw(family, seed)
        rig = build(train, gb)
        try:
            gb.simulate(
                rig, t_end=2e-3, **{k: x for k, x in arguments(train, gb).items() if k in ("initial", "inputs")}
            )
        except gb.GearblocksError:
            continue  # a train that is wrong as a whole says nothing of its parts
        _leave_out(rig, Random(seed), most=4, **arguments(train, gb))
