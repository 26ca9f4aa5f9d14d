"""How large a load forces within bounds hold: the linear programs of the core against those of scipy, over all ranges."""

from __future__ import annotations

import ctypes
import itertools
import subprocess

import numpy as np
import pytest
from scipy.optimize import linprog

from tests.c.test_core import CORE, FLAGS, _compiler

NONE, TIE = -1, 0
LOSS = 1
SEEDS = (*range(20), 327, 1231, 1541, 2437, 3186, 3354, 3888, 5575, 5577)


class _Delassus(ctypes.Structure):
    _fields_ = (("n", ctypes.c_int), ("pattern", ctypes.c_void_p), ("value", ctypes.c_void_p))


class _Problem(ctypes.Structure):
    _fields_ = (
        ("A", _Delassus),
        ("taking_part", ctypes.c_void_p),
        ("coupled", ctypes.c_void_p),
        ("room", ctypes.c_void_p),
        ("graded", ctypes.c_int),
        ("weight", ctypes.c_void_p),
    )


class _Bounds(ctypes.Structure):
    _fields_ = tuple((name, ctypes.c_void_p) for name in ("lower", "upper", "losses", "tie_of", "shrink"))


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    product = tmp_path_factory.mktemp("limit") / "limit.so"
    sources = [str(CORE / name) for name in ("gb_load_limit.c", "gb_raise.c")]
    command = [*_compiler(), *FLAGS, "-O2", "-shared", "-fPIC", f"-I{CORE}", *sources, "-lm", "-o", str(product)]
    subprocess.run(command, check=True)
    found = ctypes.CDLL(str(product))
    found.gb_load_limit.restype = ctypes.c_double
    return found


def _factor(core: ctypes.CDLL, W: np.ndarray, force: np.ndarray, bounds: dict[str, np.ndarray], most: float):
    """What the core says, and the split that it gives."""
    n = len(force)
    keep = [np.ascontiguousarray(W), np.ones(n, np.int32), np.zeros(n, np.int32), np.array(force), np.zeros(n)]
    arrays = {name: np.ascontiguousarray(value) for name, value in bounds.items()}
    problem = _Problem(_Delassus(n, None, keep[0].ctypes.data), keep[1].ctypes.data, None, None, 0, None)
    given = _Bounds(*(arrays[name].ctypes.data for name in ("lower", "upper", "losses", "tie_of")), None)
    factor = core.gb_load_limit(
        ctypes.byref(problem),
        ctypes.c_void_p(keep[2].ctypes.data),
        ctypes.byref(given),
        ctypes.c_void_p(keep[3].ctypes.data),
        ctypes.c_double(most),
        ctypes.c_void_p(keep[4].ctypes.data),
    )
    return factor, keep[4]


def _train(rng: np.random.Generator, bodies: int, frictions: int, gears: int):
    """A Delassus matrix, forces and bounds: frictions that hold one body or two, and gears of a tie and a loss each that
    lie in no ring."""
    rows, n = [], frictions + 2 * gears
    tie_of = np.full(n, NONE, np.int32)
    lower, upper, losses = np.full(n, -np.inf), np.full(n, np.inf), np.zeros((n, 5))
    for k in range(gears):
        a, b, ratio = k % bodies, (k + 1) % bodies, rng.uniform(0.3, 4.0)
        rows += [np.eye(bodies)[a] * ratio - np.eye(bodies)[b], np.eye(bodies)[a]]
        tie_of[2 * k + 1] = 2 * k
        rest = rng.uniform(0.05, 1.0)
        losses[2 * k + 1, :4] = (
            rng.uniform(0.05, 0.8),
            rest,
            -rng.uniform(0.05, 0.9),
            rest * rng.choice([1.0, rng.uniform(1.0, 4.0)]),
        )
    for k in range(frictions):
        row = rng.normal() * np.eye(bodies)[k % bodies]
        rows.append(row - (rng.random() < 0.3) * np.eye(bodies)[(k + 1) % bodies])
        upper[2 * gears + k] = rng.uniform(0.1, 3.0)
        lower[2 * gears + k] = -rng.uniform(0.1, 3.0)
    G = np.array(rows)
    return G @ np.diag(rng.uniform(0.2, 5.0, bodies)) @ G.T, {
        "lower": lower,
        "upper": upper,
        "losses": losses,
        "tie_of": tie_of,
    }


def _lost(of: np.ndarray, u: float) -> float:
    share, rest, driven, more = of[:4]
    return share * u + (1 + share) * rest if u + rest >= 0 else driven * u + (1 + driven) * more if u + more < 0 else -u


def _held(W: np.ndarray, load: np.ndarray, bounds: dict[str, np.ndarray]) -> bool:
    """Whether any forces within the bounds give the load: each piece of the losses by itself, of which both ends are on
    the line between them."""
    gears = [i for i, tie in enumerate(bounds["tie_of"]) if tie >= 0]
    pieces = []
    for i in gears:
        _, rest, _, more = bounds["losses"][i][:4]
        corners = sorted({-1e3, -more, -rest, rest, more, 1e3})
        pieces.append(list(itertools.pairwise(corners)))
    for chosen in itertools.product(*pieces):
        least, most, rows, right = bounds["lower"].copy(), bounds["upper"].copy(), [], []
        for i, (a, b) in zip(gears, chosen, strict=True):
            tie, of = bounds["tie_of"][i], bounds["losses"][i]
            least[tie], most[tie] = a, b
            for sign in (1.0, -1.0):
                at = [_lost(of, -sign * u) for u in (a + 1e-12 * (b - a), b - 1e-12 * (b - a))]
                slope = (at[1] - at[0]) / (b - a)
                row = np.zeros(len(load))
                row[i], row[tie] = sign, -slope
                rows.append(row)
                right.append(at[0] - slope * a)
        found = linprog(
            np.zeros(len(load)), A_ub=np.array(rows) if rows else None, b_ub=right or None, A_eq=W, b_eq=load,
            bounds=list(zip(least, most, strict=True)), method="highs",
        )  # fmt: skip
        if found.status == 0:
            return True
    return False


@pytest.mark.parametrize("seed", range(40))
def test_a_load_is_held_where_there_are_forces_within_the_bounds(core: ctypes.CDLL, seed: int) -> None:
    rng = np.random.default_rng(seed)
    W, bounds = _train(rng, int(rng.integers(1, 4)), int(rng.integers(1, 4)), int(rng.integers(0, 3)))
    load = rng.normal(size=len(W)) * rng.choice([0.3, 1.0, 3.0])
    factor, split = _factor(core, W, load, bounds, 1e3)
    assert _held(W, W @ load, bounds) == (factor >= 1.0), factor
    if factor >= 1.0:
        assert np.allclose(W @ split, W @ load, rtol=0, atol=1e-9 * abs(W @ load).max())
        assert _held(np.eye(len(load)), split, bounds) or factor < 1.0 + 1e-6


@pytest.mark.parametrize("seed", SEEDS)
def test_a_load_that_is_off_by_rounding_has_the_same_factor(core: ctypes.CDLL, seed: int) -> None:
    """Gears that lose nothing at rest hold any load or none, and many bounds are met at once: the search goes from corner to
    corner where it stands, and a slow change that ended it by rounding
    gave another factor (5 % off here, 133.7 for 9.4 in a train)."""
    rng = np.random.default_rng(seed)
    gears = int(rng.integers(1, 4))
    W, bounds = _train(rng, int(rng.integers(2, 6)), int(rng.integers(1, 5)), gears)
    bounds["losses"][1 : 2 * gears : 2][rng.random(gears) < 0.6, 1:4:2] = 0.0
    load = rng.normal(size=len(W)) * (rng.random(len(W)) < 0.6)
    off = [1e-13 * rng.normal(size=len(W)) for _ in range(12)]
    found = [_factor(core, W, load + each, bounds, 1e3)[0] for each in off]
    assert max(found) - min(found) < 1e-5 * max(found)


@pytest.mark.parametrize("rest", [0.0, 0.3])
@pytest.mark.parametrize("driven", [-0.1, -1.0])
def test_the_factor_has_no_jump_where_forces_in_proportion_come_to_no_limit(
    core: ctypes.CDLL, rest: float, driven: float
) -> None:
    """A gear, self-locking or not, between two bodies of which a brake without capacity holds one too, under loads on both
    that turn from one way to the other; where they are held."""
    G = np.array([[2.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    losses = np.zeros((3, 5))
    losses[LOSS, :4] = 0.4, rest, driven, 2.0 * rest
    bounds = {
        "lower": np.array([-np.inf, -np.inf, 0.0]),
        "upper": np.array([np.inf, np.inf, 0.0]),
        "losses": losses,
        "tie_of": np.array([NONE, TIE, NONE], np.int32),
    }
    largest = []
    for number in (400, 4000):
        angles = np.linspace(0.0, 2.0 * np.pi, number)
        loads = [np.linalg.lstsq(G.T, [np.cos(a), np.sin(a)], rcond=None)[0] for a in angles]
        factors = np.array([_factor(core, G @ G.T, load, bounds, 4.0)[0] for load in loads])
        assert factors.min() < 0.8 and factors.max() > 1.2
        largest.append(abs(np.diff(np.maximum(factors, 1.0))).max())
    assert largest[1] < 0.2 * largest[0]
