"""Rolling starts of random trains: the rows of the independent reference are at rest, the named speed is what was named."""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb
from tests.random.description import FIXED, Part, Train, build
from tests.random.families import draw
from tests.random.reference.elements import relative, system_of
from tests.random.reference.switches import NoEvidenceError
from tests.random.reference.system import Pair, System

pytestmark = pytest.mark.filterwarnings("ignore:.*is left first at")  # 7 rad/s are beyond some loss tables
SEEDS = [300, *(pytest.param(s, marks=pytest.mark.long) for s in range(301, 320))]
FAMILIES = ["contact", "laws", *(pytest.param(f, marks=pytest.mark.long) for f in ("smooth", "friction", "lossy"))]
NOT_KNOWN = (
    "whose ratio varies, beside a shaft without inertia",
    "carries nothing at a deflection that an expression gives",
)


def _rows(train: Train) -> tuple[np.ndarray, list[str], list[Pair]]:
    """Forms over nodes that a rolling train keeps at 0: deflections, ties, lossy gears; names of the nodes; non-circular
    pairs, whose forms hang on their angles."""
    s = system_of(train)
    sides = [side.tobytes() for p in train.parts if p.block == "NonCircularGear" for side in _sides(s, p)]
    elastic = [row for row in s.elastic if row.tobytes() not in sides]
    lossy = [g.ra - g.ratio * g.rb for g in s.lossy]
    rows = [*elastic, *s.ties, *lossy]
    return np.array(rows).reshape(len(rows), len(s.node_names)), list(s.node_names), s.pairs


def _sides(s: System, part: Part) -> list[np.ndarray]:
    """Each side of a pair, whose angle the reference has by itself."""
    return [relative(s, part, flange, "carrier") for flange in ("a", "b")]


@pytest.mark.parametrize(
    "family", ["contact", "laws", *(pytest.param(f, marks=pytest.mark.long) for f in ("smooth", "friction", "lossy"))]
)
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.few(1)
def test_nothing_is_twisted_at_a_rate(family: str, seed: int) -> None:
    drawn = draw(family, seed)
    train = drawn.with_parts(p.changed(w0=None, v0=None) if p.is_body else p for p in drawn.parts)
    try:
        rows, nodes, pairs = _rows(train)
    except NoEvidenceError:
        pytest.skip("the reference has no equations for it")
    body = train.bodies[len(train.bodies) // 2]
    rig, name = build(train, gb), f"{body.name}.{'v' if body.block == 'Mass' else 'w'}"
    try:
        run = gb.simulate(rig, t_end=1e-9, initial=gb.rolling({name: 7.0}), inputs=_inputs(train))
    except gb.ParameterError as error:
        if any(words in str(error) for words in NOT_KNOWN):
            pytest.skip(str(error))
        held = np.zeros(len(nodes))
        held[nodes.index(body.node("a"))] = 1.0
        free = np.linalg.lstsq(np.vstack([rows, held]), np.r_[np.zeros(len(rows)), 7.0], rcond=None)[0]
        contradicts = np.abs(rows @ free).max(initial=0.0) > 1e-6 or "locked" in str(error) or "moves" in str(error)
        if not contradicts:
            pytest.fail(str(error))
        return
    if any(event.kind == "impact" and event.t == 0.0 for event in run.events):
        return  # at a stop, which throws it back at once
    assert run[name][0] == pytest.approx(7.0, rel=1e-14)
    speeds = {p.node("a"): run[f"{p.name}.{'v' if p.block == 'Mass' else 'w'}"][0] for p in train.bodies}
    known = np.array([n in speeds or n in FIXED for n in nodes])
    w = np.array([speeds.get(n, 0.0) for n in nodes])
    angles = {p.node("a"): run[f"{p.name}.{'s' if p.block == 'Mass' else 'phi'}"][0] for p in train.bodies}
    phi = np.array([angles.get(n, 0.0) for n in nodes])
    for pair in pairs:
        slope = pair.law[1](float(pair.a @ phi) + pair.phase)
        rows = np.vstack([rows, slope * pair.a + pair.sign * pair.b])
    seen = rows[~(np.abs(rows[:, ~known]).max(axis=1, initial=0.0) > 0)]
    assert np.abs(seen @ w).max(initial=0.0) <= 1e-12 * np.abs(w).max()


def _inputs(train: Train) -> dict[str, float]:
    return {x[0]: 0.0 for x in train.inputs}
