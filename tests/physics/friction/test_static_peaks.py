"""Static peaks beside neighbours: what breaks loose carries less, and what it passes on decides about the others.

The reference enumerates what every friction element could do at rest and keeps the sets that Newton's law and the bounds
allow; under constant torques the accelerations stay as they are.
"""

import itertools

import numpy as np
import pytest

import gearblocks as gb

METHODS = ["dp5", "dp8", "rodas", "auto"]
EXACT = 1e-9  # linear in time; implicit steps solve with matrices


def _pair(load, capacity, peak, bearing, *, bearing_peak=1.0):
    """A driven shaft, a clutch with a static peak, and a shaft in a bearing."""
    rig = gb.Drivetrain("pair")
    a, b = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=0.25))
    rig.chain(rig.add("drive", gb.Torque(tau=load)), a, rig.add("clutch", gb.Clutch(capacity=capacity, peak=peak)), b)
    rig.connect(rig.add("bearing", gb.BearingFriction(coulomb=bearing, peak=bearing_peak)).a, b.b)
    return rig


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_clutch_that_breaks_loose_leaves_the_bearing_behind_it_at_rest(method, sign):
    """Its peak of 2.3933 N m would turn the bearing of 2 N m, the 1.841 N m that it carries while it slides do not."""
    run = gb.simulate(_pair(6.6 * sign, 1.841, 1.3, 2.0), t=[0.0, 1.0], method=method)
    assert run["a.w"][-1] == pytest.approx(sign * (6.6 - 1.841), rel=EXACT)
    assert run["b.w"][-1] == 0.0
    assert run["clutch.mode"][-1] == -sign
    assert run.events == ()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("load", "peaks", "modes"),
    [
        (2.1, (1.5, 1.2), (0.0, 0.0)),  # within both peaks
        (2.7, (1.5, 1.2), (0.0, 1.0)),  # beyond that of the bearing alone: both shafts go together
        (2.7, (1.2, 1.5), (-1.0, 0.0)),  # beyond that of the clutch alone
        (9.0, (1.5, 1.2), (-1.0, 0.0)),  # far beyond both: the clutch then carries as much as the bearing holds
    ],
)
@pytest.mark.few(3)
def test_of_two_peaks_in_a_row_the_weaker_one_breaks(method, load, peaks, modes):
    """From rest; clutch and bearing carry 2 N m each while they slide."""
    run = gb.simulate(_pair(load, 2.0, peaks[0], 2.0, bearing_peak=peaks[1]), t=[0.0, 1.0], method=method)
    assert (run["clutch.mode"][-1], run["bearing.mode"][-1]) == modes
    both = 1.0 + 0.25
    a = {(0.0, 0.0): 0.0, (0.0, 1.0): (load - 2.0) / both, (-1.0, 0.0): load - 2.0}[modes]
    assert run["a.w"][-1] == pytest.approx(a, rel=EXACT, abs=1e-15)


@pytest.mark.parametrize("method", METHODS)
def test_what_the_load_exceeds_most_breaks_first_and_may_save_the_other(method):
    """6 N m exceed the peaks of 3 N m (clutch) and 2.85 N m (bearing). Once the bearing turns, the clutch needs 2.72 N m."""
    run = gb.simulate(_pair(6.0, 2.0, 1.5, 1.9, bearing_peak=1.5), t=[0.0, 1.0], method=method)
    assert (run["clutch.mode"][-1], run["bearing.mode"][-1]) == (0.0, 1.0)
    assert run["clutch.torque"][-1] == pytest.approx((0.25 * 6.0 + 1.0 * 1.9) / 1.25, rel=EXACT)
    assert run["a.w"][-1] == run["b.w"][-1] == pytest.approx((6.0 - 1.9) / 1.25, rel=EXACT)


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_a_rising_load_breaks_the_clutch_at_its_peak_and_nothing_else(method):
    """a stands until load = 1.841 * 1.3; the jump of the clutch to 1.841 N m is no reason for the bearing to let go."""
    run = gb.simulate(_pair(gb.time, 1.841, 1.3, 2.5), t=[0.0, 4.0], method=method, rtol=1e-8)
    ((component, t, before, after),) = [(e.component, e.t, e.before, e.after) for e in run.events]
    assert (component, before, after) == ("clutch", 0.0, -1.0)
    assert t == pytest.approx(1.841 * 1.3, rel=1e-9)
    assert run["a.w"][-1] == pytest.approx((4.0**2 - t**2) / 2 - 1.841 * (4.0 - t), rel=1e-7)
    assert run["b.w"][-1] == 0.0


# -- against an enumeration -------------------------------------------------------------------------------------------


def _accelerations(J, tau, rows, sliding, peaks):
    """The accelerations from rest that each consistent set of modes (0 stuck, 1, -1) leads to."""
    found = []
    for modes in itertools.product((0, 1, -1), repeat=len(rows)):
        stuck = [i for i, mode in enumerate(modes) if mode == 0]
        force = np.array(tau) - rows.T @ (np.array(modes) * sliding)
        held = np.zeros(len(rows))
        if stuck:
            G = rows[stuck]
            held[stuck] = -np.linalg.solve(G / J @ G.T, G @ (force / J))
        a = (force + rows.T @ held) / J
        slip = rows @ a
        slides = all(mode == 0 or mode * slip[i] > 1e-12 for i, mode in enumerate(modes))
        if slides and np.all(np.abs(held) <= peaks * sliding):
            found.append(a)
    return found


@pytest.mark.long
def test_what_breaks_at_rest_is_what_an_enumeration_of_all_sets_allows():
    """Three shafts in a row with two clutches and a bearing in the middle; 150 draws."""
    names = ("one", "two", "three")
    rig = gb.Drivetrain("row")
    one, two, three = (rig.add(n, gb.Inertia(J=1.0)) for n in names)
    c1, c2 = (rig.add(n, gb.Clutch(capacity=1.0, peak=1.5)) for n in ("c1", "c2"))
    rig.chain(one, c1, two, c2, three)
    rig.connect(rig.add("b", gb.BearingFriction(coulomb=1.0, peak=1.5)).a, two.b)
    loads = [gb.Parameter(f"load_{n}", 0.0, "N m") for n in names]
    for n, body, load in zip(names, (one, two, three), loads, strict=True):
        rig.connect(rig.add(f"on_{n}", gb.Torque(tau=load)).flange, body.a)
    model = gb.build(rig)
    rows = np.array([[-1.0, 1, 0], [0, -1, 1], [0, 1, 0]])
    paths = ("c1.capacity", "c2.capacity", "b.coulomb")
    rng = np.random.default_rng(9)
    unique = 0
    for draw in range(150):
        J, tau = 10 ** rng.uniform(-1, 1, 3), rng.uniform(-6, 6, 3) * (rng.random(3) < 0.7)
        sliding, peaks = rng.uniform(0.3, 4, 3), np.where(rng.random(3) < 0.7, rng.uniform(1, 2, 3), 1.0)
        values = {f"{n}.J": x for n, x in zip(names, J, strict=True)}
        values |= {f"load_{n}": x for n, x in zip(names, tau, strict=True)}
        values |= dict(zip(paths, sliding, strict=True))
        values |= {f"{path.split('.')[0]}.peak": x for path, x in zip(paths, peaks, strict=True)}
        run = gb.simulate(model, t=[0.0], method=METHODS[draw % 4], parameters=values)
        allowed = _accelerations(J, tau, rows, sliding, peaks)
        size = 1e-9 * np.max(np.abs(tau) / J + 1)
        got = np.array([run[f"{n}.alpha"][0] for n in names])
        assert any(np.max(np.abs(got - a)) <= size for a in allowed), (draw, got, allowed)
        unique += all(np.max(np.abs(a - allowed[0])) <= size for a in allowed)
    assert unique > 100  # where peaks leave a choice, the one that the run makes must be among them
