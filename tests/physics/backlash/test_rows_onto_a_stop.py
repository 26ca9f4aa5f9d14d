"""Bodies in rows and trees drag each other onto a stop across rigid gaps: each impact opens contacts for nothing, those
that close open the next ones, and in the end all rest."""

import numpy as np
import pytest

import gearblocks as gb

# For each body but the first one: the body that drags it, and the ratio of a gear between them.
TREES = {
    "three in a row": [(0, 1.0), (1, 1.0)],
    "four in a row": [(0, 1.0), (1, 1.0), (2, 1.0)],
    "two behind the second": [(0, 1.0), (1, 1.0), (1, 1.0)],
    "a tree with gears": [(0, -1.7), (1, 1.0), (1, 1.0), (2, 0.4)],
}
PLAY = 0.3


def _rig(tree, shuffle):
    """Angles in `places` are those at which every gap is closed as it drags and the first body lies at the stop."""
    number = gb.Parameter
    rates, places = [1.0], [0.0]
    for before, ratio in tree:
        rates.append(rates[before] / ratio)
        places.append(places[before] / ratio - PLAY * float(np.sign(rates[-1])))
    rig, parts = gb.Drivetrain("rows"), {}
    for i, (rate, place) in enumerate(zip(rates, places, strict=True)):
        parts[f"body{i}"] = gb.Inertia(J=number(f"J{i}", 1.0), phi0=place, w0=rate * number("fast", 0.1))
        parts[f"hold{i}"] = gb.Torque(tau=-1.0 / rate * number(f"load{i}", 1.0))
    for i, (_, ratio) in enumerate(tree, 1):
        hit = gb.HuntCrossley(restitution=number(f"kept{i}", 0.5))
        parts[f"gap{i}"] = gb.Lash(k=1e3, half_gap=PLAY, contact_damping=hit)
        parts[f"gear{i}"] = gb.IdealGear(ratio=ratio)
    parts["stop"] = gb.HardStop(restitution=number("kept", 0.6), upper=0.0)
    parts["drive"] = gb.Torque(tau=20.0)
    order = list(parts)
    shuffle.shuffle(order)
    made = {name: rig.add(name, parts[name]) for name in order}
    for i, (before, _) in enumerate(tree, 1):
        rig.chain(made[f"body{before}"], made[f"gear{i}"], made[f"gap{i}"], made[f"body{i}"])
    for i in range(len(places)):
        rig.connect(made[f"body{i}"].b, made[f"hold{i}"].flange)
    rig.connect(made["stop"].a, made["body0"].a, made["drive"].flange)
    return rig.without(*(f"gap{i}.compliance" for i in range(1, len(places)))), places


@pytest.mark.parametrize("name", TREES)
@pytest.mark.parametrize("method", ["dp5", "rodas"])
@pytest.mark.few(2)
def test_all_come_to_rest(name, method):
    """What presses the gaps adds up to less than the drive; energy is what the impacts lose."""
    random = np.random.default_rng(23)
    rig, places = _rig(TREES[name], random)
    model, bodies = gb.build(rig), range(len(places))
    for _ in range(5):
        values = {f"J{i}": 10 ** random.uniform(-1.5, 0.5) for i in bodies} | {"fast": 10 ** random.uniform(-2, 0)}
        values |= {f"load{i}": random.uniform(0.5, 4.5) for i in bodies}
        values |= {key: random.uniform(0.2, 0.8) for key in ("kept", *(f"kept{i}" for i in bodies[1:]))}
        rtol = 10 ** random.uniform(-8, -4)
        run = gb.simulate(model, t_end=300.0, parameters=values, method=method, rtol=rtol)
        assert run["stop.contact"][-1] == 1.0, values
        for i, place in enumerate(places):
            assert abs(run[f"body{i}.w"][-1]) < 1e-12, (i, values)
            assert run[f"body{i}.phi"][-1] == pytest.approx(place, abs=1e-11), (i, values)
        assert abs(run.energy.residual) < 10 * rtol, values
