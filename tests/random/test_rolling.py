"""Rolling starts of random trains: the rows of the independent reference are at rest, the named speed is what was named."""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb
from tests.random.description import FIXED, Train, build
from tests.random.families import draw
from tests.random.reference.elements import system_of
from tests.random.reference.switches import NoEvidenceError

SEEDS = [300, *(pytest.param(s, marks=pytest.mark.long) for s in range(301, 320))]
FAMILIES = ["contact", "laws", *(pytest.param(f, marks=pytest.mark.long) for f in ("smooth", "friction", "lossy"))]
NOT_KNOWN = (
    "whose ratio varies, beside a shaft without inertia",
    "carries nothing at a deflection that an expression gives",
)


def _rows(train: Train) -> tuple[np.ndarray, list[str]]:
    """Forms over nodes that a rolling train keeps at 0: deflections, ties, lossy gears; names of the nodes."""
    s = system_of(train)
    lossy = [g.ra - g.ratio * g.rb for g in s.lossy]
    rows = [*s.elastic, *s.ties, *lossy]
    return np.array(rows).reshape(len(rows), len(s.node_names)), list(s.node_names)


@pytest.mark.parametrize(
    "family", ["contact", "laws", *(pytest.param(f, marks=pytest.mark.long) for f in ("smooth", "friction", "lossy"))]
)
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.few(1)
def test_nothing_is_twisted_at_a_rate(family: str, seed: int) -> None:
    drawn = draw(family, seed)
    train = drawn.with_parts(p.changed(w0=None, v0=None) if p.is_body else p for p in drawn.parts)
    try:
        rows, nodes = _rows(train)
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
    assert run[name][0] == pytest.approx(7.0, rel=1e-14)
    speeds = {p.node("a"): run[f"{p.name}.{'v' if p.block == 'Mass' else 'w'}"][0] for p in train.bodies}
    known = np.array([n in speeds or n in FIXED for n in nodes])
    w = np.array([speeds.get(n, 0.0) for n in nodes])
    seen = rows[~(np.abs(rows[:, ~known]).max(axis=1, initial=0.0) > 0)]
    assert np.abs(seen @ w).max(initial=0.0) <= 1e-12 * np.abs(w).max()


def _inputs(train: Train) -> dict[str, float]:
    return {x[0]: 0.0 for x in train.inputs}
