"""The reference of gearboxes with a gap, of the heat of locks that strike, and of motions that ties follow, by closed forms."""

import numpy as np
import pytest

from tests.random.description import GROUND, Part, Train
from tests.random.expressions import TIME, Node, table, thing
from tests.random.reference import reference_motion

T = np.linspace(0.0, 1.0, 21)


def _train(*parts: Part) -> Train:
    return Train("closed form", 0, parts, 1.0)


def _wheel(name: str, J: float, w0: float | None = None) -> Part:
    return Part(name, "Inertia", (("J", J), *(() if w0 is None else (("w0", w0),))), (("a", name),))


@pytest.mark.parametrize("ratio", [2.0, -0.5])
def test_a_wheel_that_winds_up_a_gearbox_swings_out_slower_and_back_slower_still(ratio: float) -> None:
    """J phi'' = -k phi/(ratio^2 eta1) on the way out, where a drives, and -eta2 k phi/ratio^2 back to the middle."""
    J, k, w0, eta1, eta2 = 0.5, 80.0, 3.0, 0.7, 0.6
    fields = (("ratio", ratio), ("efficiency", (eta1, eta2)), ("k", k))
    box = Part("box", "Gearbox", fields, (("a", "j"), ("b", GROUND), ("housing", GROUND)))
    out, back = np.sqrt(k / (ratio**2 * eta1 * J)), np.sqrt(eta2 * k / (ratio**2 * J))
    far, turn = w0 / out, np.pi / 2 / out
    t = T[turn + np.pi / 2 / back > T]
    wanted = np.where(t < turn, far * np.sin(out * t), far * np.cos(back * (t - turn)))
    motion = reference_motion(_train(_wheel("j", J, w0), box), T)
    assert motion.angles[0][: len(t)] == pytest.approx(wanted, abs=1e-9)


def test_a_gearbox_whose_bearing_torque_a_load_does_not_exceed_stands_behind_its_gap() -> None:
    fields = (("ratio", 2.0), ("efficiency", (0.9, 0.8)), ("bearing", (1.5, 1.5)), ("k", 50.0), ("half_gap", 0.1))
    box = Part("box", "Gearbox", fields, (("a", "a"), ("b", "b"), ("housing", GROUND)))
    load = Part("load", "Torque", (("tau", 0.4),), (("flange", "b"),))
    motion = reference_motion(_train(_wheel("a", 1.0, 0.0), _wheel("b", 1.0, 0.0), box, load), T)
    w = np.sqrt(
        50.0
    )  # b flies through half the gap, then swings about 0.4/50: what it asks of the gear is below 1.5 at a
    hits = np.sqrt(2 * 0.1 / 0.4)
    since = np.maximum(T - hits, 0.0)
    swing = 0.1 + 0.4 / 50 * (1 - np.cos(w * since)) + 0.4 * hits / w * np.sin(w * since)
    assert motion.angles[0] == pytest.approx(np.zeros(21), abs=1e-12)
    assert motion.angles[1] == pytest.approx(np.where(hits > T, 0.2 * T**2, swing), abs=1e-9)


def test_a_dog_that_closes_is_heated_by_the_energy_of_its_slip() -> None:
    port = thing("HeatPort", T="oil")
    oil = Part("oil", "ThermalMass", (("C", 4.0),), ())
    closes = table((0.0, 0.5), (-1.0, 1.0), "step")
    dog = Part("dog", "DogClutch", (("engaged", closes), ("heat", port)), (("a", "a"), ("b", "b")))
    motion = reference_motion(_train(_wheel("a", 1.0, 3.0), _wheel("b", 2.0, -1.0), dog, oil), T)
    lost = 0.5 * (1.0 * 2.0 / 3.0) * 4.0**2
    assert motion.rises[0] == pytest.approx(np.where(T < 0.5, 0.0, lost / 4.0), abs=1e-10)


def test_small_changes_of_a_state_leave_a_motion_that_is_prescribed_as_it_is() -> None:
    start = Part(
        "start", "Acceleration", (("alpha", 30.0 * Node("sin", (7.0 * TIME,))), ("w0", 1.0)), (("flange", "a"),)
    )
    shaft = Part("shaft", "Shaft", (("k", 20.0),), (("a", "a"), ("b", "b")))
    brake = Part("brake", "Brake", (("capacity", 2.0),), (("a", "b"), ("housing", GROUND)))
    train = _train(_wheel("a", 1.0), _wheel("b", 1.0, 0.0), start, shaft, brake)
    wanted = 1.0 + 30.0 / 7.0 * (1 - np.cos(7.0 * T))
    for change in (0.0, 1e-8):
        motion = reference_motion(train, T, change)
        assert motion.speeds[0] == pytest.approx(wanted, abs=1e-7 if change else 1e-9)
