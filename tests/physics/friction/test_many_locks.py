"""Many switched constraints in one train: rows, stars and pairs of rows against closed forms, also on a small stack."""

import threading

import numpy as np
import pytest

import gearblocks as gb

EXACT = 1e-11  # sums over a thousand bodies round, and nothing else


def _row(count, drive, capacity, inertia=1.0, w0=0.0):
    """A drive, a body, and `count` times a clutch and a body: c0 b1 c1 b2 ..., the drive at b0."""
    rig = gb.Drivetrain("row")
    parts = [rig.add("drive", gb.Torque(tau=drive)), rig.add("b0", gb.Inertia(J=inertia, w0=w0))]
    for i in range(count):
        parts.append(rig.add(f"c{i}", gb.Clutch(capacity=capacity(i) if callable(capacity) else capacity)))
        parts.append(rig.add(f"b{i + 1}", gb.Inertia(J=inertia)))
    rig.chain(*parts)
    return rig


@pytest.mark.long
@pytest.mark.parametrize("method", ["auto", "rodas"])
def test_a_thousand_stuck_clutches_turn_as_one_body(method):
    run = gb.simulate(_row(1000, 100.0, 1e6), t=[0.0, 2.0], method=method)
    ends = np.array([run[f"b{i}.w"][-1] for i in (0, 1, 499, 1000)])
    assert len(set(ends)) == 1
    assert ends[0] == pytest.approx(100.0 * 2.0 / 1001, rel=EXACT)
    torque = np.array([run[f"c{i}.torque"][-1] for i in (0, 500, 999)])
    assert torque == pytest.approx(100.0 * np.array([1000, 500, 1]) / 1001, rel=1e-9)


@pytest.mark.long
def test_the_first_of_a_thousand_clutches_slides_and_the_others_do_not():
    run = gb.simulate(_row(1000, 100.0, 10.0), t=[0.0, 1.0])
    assert run["b0.w"][-1] == pytest.approx(100.0 - 10.0, rel=EXACT)
    assert run["b1.w"][-1] == run["b1000.w"][-1] == pytest.approx(10.0 / 1000, rel=EXACT)
    assert [run[f"c{i}.mode"][-1] for i in (0, 1, 999)] == [-1.0, 0.0, 0.0]


@pytest.mark.long
def test_a_weak_clutch_in_the_middle_parts_a_row_of_two_hundred():
    run = gb.simulate(_row(200, 100.0, lambda i: 5.0 if i == 99 else 1e3), t=[0.0, 1.0])
    assert run["b0.w"][-1] == run["b99.w"][-1] == pytest.approx((100.0 - 5.0) / 100, rel=EXACT)
    assert run["b100.w"][-1] == run["b200.w"][-1] == pytest.approx(5.0 / 101, rel=EXACT)


@pytest.mark.long
def test_a_rising_torque_breaks_the_first_of_two_hundred_equal_clutches_when_its_share_is_due():
    """tau = 50 t passes 200/201 of itself to c0, which holds 10."""
    run = gb.simulate(_row(200, 50.0 * gb.time, 10.0), t=[0.0, 1.0], rtol=1e-8)
    (event,) = run.events
    assert event.component == "c0"
    t = event.t
    assert t == pytest.approx(10.0 * 201 / 200 / 50.0, rel=1e-9)
    assert run["b0.w"][-1] == pytest.approx(25.0 * t**2 / 201 + 25.0 * (1.0 - t**2) - 10.0 * (1.0 - t), rel=1e-8)


@pytest.mark.long
def test_rows_that_meet_in_any_order_of_their_clutches_give_the_same():
    """Elimination takes the clutches in the order of their names in the train: the motion does not know it."""
    count, order = 60, np.random.default_rng(5).permutation(60)
    ends = []
    for sequence in (range(count), order):
        rig = gb.Drivetrain("row")
        bodies = [rig.add(f"b{i}", gb.Inertia(J=1.0 + i % 3)) for i in range(count + 1)]
        for i in sequence:
            clutch = rig.add(f"c{i}", gb.Clutch(capacity=8.0 if i == 20 else 1e3))
            rig.connect(bodies[i].b, clutch.a)
            rig.connect(clutch.b, bodies[i + 1].a)
        rig.connect(rig.add("drive", gb.Torque(tau=90.0)).flange, bodies[0].a)
        ends.append([gb.simulate(rig, t=[0.0, 1.0])[f"b{i}.w"][-1] for i in (0, 20, 21, 60)])
    before, after = sum(1.0 + i % 3 for i in range(21)), sum(1.0 + i % 3 for i in range(21, 61))
    assert ends[0] == pytest.approx([82.0 / before] * 2 + [8.0 / after] * 2, rel=EXACT)
    assert ends[1] == pytest.approx(ends[0], rel=EXACT)


@pytest.mark.long
def test_a_hundred_and_thirty_brakes_on_one_shaft_share_what_they_hold():
    """All act on each other, and all but one follow from it: the dense form of their matrix, and the split of a load."""
    rig = gb.Drivetrain("star")
    shaft = rig.add("shaft", gb.Inertia(J=2.0))
    rig.connect(rig.add("drive", gb.Torque(tau=65.0)).flange, shaft.a)
    for i in range(130):
        rig.connect(rig.add(f"brake{i}", gb.Brake(capacity=1.0)).a, shaft.b)
    run = gb.simulate(rig, t=[0.0, 0.5])
    assert run["shaft.w"][-1] == 0.0
    assert [run[f"brake{i}.torque"][-1] for i in (0, 64, 129)] == pytest.approx([0.5] * 3, rel=1e-4)  # of rank 1


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp8", "rodas"])
def test_locks_behind_gears_are_as_exact_as_ties(method):
    """Speeds in the ratio 3 : 1 : 2, all clutches stuck: one body with the inertias 1, 1/9, 4/9 seen from the first."""
    rig = gb.Drivetrain("geared")
    parts = [gb.Torque(tau=6.0), gb.Inertia(J=1.0), gb.Clutch(capacity=1e3), gb.IdealGear(ratio=3.0), gb.Inertia(J=1.0)]
    parts += [gb.Clutch(capacity=1e3), gb.IdealGear(ratio=0.5), gb.Inertia(J=1.0)]
    names = ("drive", "one", "c1", "g1", "two", "c2", "g2", "three")
    rig.chain(*(rig.add(name, part) for name, part in zip(names, parts, strict=True)))
    run = gb.simulate(rig, t=[0.0, 1.0], method=method)
    assert run["one.w"][-1] == pytest.approx(6.0 / (1.0 + 1.0 / 9 + 4.0 / 9), rel=1e-10)
    assert abs(run["three.w"][-1]) == pytest.approx(run["one.w"][-1] * 2.0 / 3.0, rel=1e-14)
    assert run["c2.w_rel"][-1] == 0.0


@pytest.mark.parametrize(
    ("lock", "held"),
    [
        (gb.Clutch(capacity=10.0), 10.0),
        pytest.param(gb.OneWayClutch(capacity=10.0), 100.0 * 300 / 301, marks=pytest.mark.long),
        pytest.param(gb.Freewheel(), 100.0 * 300 / 301, marks=pytest.mark.long),
        pytest.param(gb.DogClutch(engaged=1.0), 100.0 * 300 / 301, marks=pytest.mark.long),
    ],
    ids=["clutches", "one-way clutches", "freewheels", "dog clutches"],
)
def test_three_hundred_locks_need_no_more_than_a_stack_of_one_mebibyte(lock, held):
    rig = gb.Drivetrain("row")
    parts = [rig.add("drive", gb.Torque(tau=100.0)), rig.add("b0", gb.Inertia(J=1.0))]
    for i in range(300):
        parts += [rig.add(f"c{i}", lock), rig.add(f"b{i + 1}", gb.Inertia(J=1.0))]
    rig.chain(*parts)
    model = gb.build(rig)
    found = []
    size = threading.stack_size(1 << 20)
    try:
        thread = threading.Thread(target=lambda: found.append(gb.simulate(model, t=[0.0, 1.0])["b0.w"][-1]))
        thread.start()
    finally:
        threading.stack_size(size)
    thread.join()
    assert found == [pytest.approx(100.0 - held, rel=EXACT)]


@pytest.mark.long
@pytest.mark.parametrize("sense", [1, -1])
def test_six_hundred_freewheels_that_nothing_loads_yet_are_looked_at_together(sense):
    """Whether each stays locked is asked of the motion to come, once for all: one by one it took 5 s, now 0.05 s."""
    rig = gb.Drivetrain("row")
    parts = [rig.add("drive", gb.Torque(tau=sense * gb.sin(5 * gb.time))), rig.add("b0", gb.Inertia(J=1.0))]
    for i in range(600):
        parts += [rig.add(f"c{i}", gb.Freewheel()), rig.add(f"b{i + 1}", gb.Inertia(J=1.0))]
    rig.chain(*parts)
    run = gb.simulate(rig, t=[0.0, 0.05], method="dp8", rtol=1e-8)
    moved = 601 if sense > 0 else 1
    assert run["b0.w"][-1] == pytest.approx(sense * (1 - np.cos(0.25)) / 5 / moved, rel=1e-7)
    assert run["b600.w"][-1] == (run["b0.w"][-1] if sense > 0 else 0.0)
    assert run.stats.cpu_seconds < 1.0


@pytest.mark.long
def test_a_lasting_set_of_locks_moves_as_the_rigid_train_and_still_lets_go():
    """Six bodies, one spring, four locks: as with rigid shafts; a load that grows later breaks the weakest of them."""

    def train(lock):
        rig = gb.Drivetrain("six")
        parts = [rig.add("drive", gb.Torque(tau=gb.sin(5 * gb.time)))]
        for i in range(6):
            parts.append(rig.add(f"J{i}", gb.Inertia(J=1.0)))
            if i < 5:
                parts.append(rig.add(f"s{i}", gb.Shaft(k=1e4) if i == 0 else lock(i)))
        rig.chain(*parts)
        return rig

    t = np.linspace(0.0, 2.0, 11)
    locked = gb.simulate(train(lambda i: gb.Clutch(capacity=1e3)), t=t, rtol=1e-9)
    tied = gb.simulate(train(lambda i: gb.Shaft(rigid=True)), t=t, rtol=1e-9)
    assert np.max(np.abs(locked["J5.w"] - tied["J5.w"])) < 1e-8 * np.max(np.abs(tied["J5.w"]))
    assert not locked.events
    weak = gb.simulate(train(lambda i: gb.Clutch(capacity=0.3 if i == 2 else 1e3)), t=t, rtol=1e-9)
    assert weak.events[0].component == "s2"
    torque = gb.simulate(train(lambda i: gb.Clutch(capacity=1e3)), t=[0.0, weak.events[0].t], rtol=1e-9)["s2.torque"][
        -1
    ]
    assert abs(torque) == pytest.approx(0.3, rel=1e-6)


def _six(lock):
    """Six bodies under a torque that begins at 0, one spring; what `lock` gives between the others."""
    rig = gb.Drivetrain("six bodies")
    parts = [rig.add("drive", gb.Torque(tau=gb.sin(5 * gb.time))), rig.add("J0", gb.Inertia(J=1.0))]
    for i in range(5):
        parts += [rig.add(f"s{i}", lock() if i else gb.Shaft(k=1e4)), rig.add(f"J{i + 1}", gb.Inertia(J=1.0))]
    rig.chain(*parts)
    return rig


@pytest.mark.long
@pytest.mark.parametrize("method", ["auto", "dp8", "dp5", "rodas"])
@pytest.mark.parametrize(
    "lock",
    [
        lambda: gb.Clutch(capacity=1e3),
        lambda: gb.DogClutch(engaged=1.0),
        lambda: gb.Clutch(capacity=1e3, peak=2.0),
    ],
    ids=["clutches", "dog clutches", "static peaks"],
)
@pytest.mark.few(1)
def test_locks_that_last_take_the_steps_of_rigid_shafts(lock, method):
    """One look out of rest tells the fastest rate of a train that begins with locks no better than that of another one."""
    locked, rigid = (gb.simulate(_six(x), t_end=2.0, method=method) for x in (lock, lambda: gb.Shaft(rigid=True)))
    assert locked.stats.steps <= 1.03 * rigid.stats.steps
    assert locked["J5.w"][-1] == pytest.approx(rigid["J5.w"][-1], rel=1e-5)
