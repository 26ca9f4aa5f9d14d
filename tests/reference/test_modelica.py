"""Four examples of the Modelica Standard Library against runs from elsewhere (tests/data/modelica_*.csv).

Those come from an event-driven integration, two methods agreeing to 1e-11 of each signal's scale; every 10th or 20th row
is kept here.
"""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb

DATA = Path(__file__).parents[1] / "data"


def _shipped():
    path = Path(__file__).parents[2] / "models" / "modelica_examples.py"
    spec = importlib.util.spec_from_file_location("modelica_examples_model", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


modelica = _shipped()

# by signal of the reference: our output and the sign between them
FIRST = {
    "damper.phi_rel": ("inertia2.phi", -1),
    "damper.w_rel": ("damper.w_rel", 1),
    "inertia3.phi": ("inertia3.phi", 1),
    "inertia3.w": ("inertia3.w", 1),
}
BEARING = {name: (name, 1) for name in ("load.phi", "load.w", "shaft.phi", "shaft.w")} | {
    "springDamper.phi_rel": ("springDamper.twist", 1),
    "springDamper.w_rel": ("springDamper.twist_rate", 1),
}
WHEEL = {"inertia.phi": ("inertia.phi", 1), "inertia.w": ("inertia.w", 1)}
CASES = [
    (modelica.build, "First", FIRST),
    (modelica.first_grounded, "First", FIRST),
    (modelica.elastic_bearing, "ElasticBearing", BEARING),
    (modelica.rolling_wheel, "RollingWheel", WHEEL),
]


@pytest.mark.parametrize(("make", "data", "signals"), CASES, ids=lambda x: getattr(x, "__name__", ""))
def test_every_signal_is_that_of_the_reference(make, data, signals):
    path = DATA / f"modelica_{data}.csv"
    names = path.read_text(encoding="utf8").splitlines()[0].split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    assert set(signals) == set(names[1:])
    model = gb.build(make())
    for rtol, tolerance in ((1e-9, 1e-6), (1e-6, 1e-4)):  # the tight one and the default
        run = gb.simulate(model, t=table[:, 0], rtol=rtol)
        for column, name in enumerate(names[1:], 1):
            ours, sign = signals[name]
            scale = np.abs(table[:, column]).max()
            assert np.abs(sign * run[ours] - table[:, column]).max() <= tolerance * scale, (name, rtol)


def test_the_rolling_wheel_follows_its_closed_form():
    t = np.linspace(0.0, 5.0, 501)
    run = gb.simulate(modelica.rolling_wheel(), t=t, rtol=1e-10)
    after = np.maximum(t - 0.1, 0.0)
    # 100 steps at rtol 1e-10, angles up to 21 rad
    assert np.abs(run["inertia.w"] - 5 * np.tanh(after)).max() < 1e-8
    assert np.abs(run["mass.s"] - 5 * np.log(np.cosh(after))).max() < 1e-8
