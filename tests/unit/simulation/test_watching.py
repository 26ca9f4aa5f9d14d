"""A run of a train from which effects were left out says whether they would have acted."""

import pickle
import runpy
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.simulation import resonances

SCENES = Path(__file__).parents[4] / "shared" / "reference" / "scenes.py"


def _bearing(table: gb.Table, w0: float = 8.0) -> gb.Drivetrain:
    rig = gb.Drivetrain("bearing")
    rig.chain(rig.add("rotor", gb.Inertia(J=1.0, w0=w0)), rig.add("bearing", gb.BearingFriction(torque=table)))
    return rig


def test_a_friction_table_that_a_run_leaves_is_named_once_with_how_far() -> None:
    with pytest.warns(
        gb.GearblocksWarning, match=r"'bearing\.torque' is left first at 0 s, up to 8 .*extrapolate"
    ) as said:
        run = gb.simulate(_bearing(gb.Table([0, 1], [0.5, 1.0])), t_end=1.0)
    assert len(said) == 1
    (row,) = run.watched.tables
    assert (row.times, row.first, row.high) == (1, 0.0, 8.0)


@pytest.mark.long
@pytest.mark.parametrize(("table", "w0"), [
    (gb.Table([0, 1, 2], [0.5, 1.0, 1.0]), 8.0),
    (gb.Table([0, 1], [0.5, 1.0], extrapolate="linear"), 8.0),
    (gb.Table([0, 10], [0.5, 1.0]), 8.0),
    (gb.Table([0, 1], [0.5, 1.0], "step"), 8.0),
])  # fmt: skip
def test_a_table_that_ends_level_goes_on_or_is_not_left_says_nothing(table: gb.Table, w0: float) -> None:
    run = gb.simulate(_bearing(table, w0), t_end=1.0)
    assert not any(row.times for row in run.watched.tables)


@pytest.mark.parametrize(
    ("x", "rest", "limit"), [((-0.1, 0.1), 0.0, 0.1), ((-0.2, 0.1), 0.0, 0.2), ((-0.1, 0.1), 0.3, 0.4)]
)
def test_a_table_over_the_twist_that_a_run_leaves_is_named(x: tuple[float, float], rest: float, limit: float) -> None:
    def of(table: gb.Table) -> gb.Drivetrain:
        rig = gb.Drivetrain("spring")
        rotor = rig.add("rotor", gb.Inertia(J=1.0, phi0=rest, w0=4.0))
        rig.chain(
            rig.add("wall", gb.Fixed()), rig.add("spring", gb.Shaft(torque=table, rest=rest, phi_rel0=rest)), rotor
        )
        return rig

    words = rf"'spring\.torque' is left .*beyond its points, {x[0]} to {x[1]}, it is held; .*extrapolate"
    with pytest.warns(gb.GearblocksWarning, match=words):
        run = gb.simulate(of(gb.Table(x, [10 * y for y in x])), t_end=2.0)
    row = run.watched.tables[0]
    assert (rest + 4.0 * row.first >= limit - 1e-9) and row.high > limit
    for quiet in (gb.Table(x, [20 * y for y in x], extrapolate="linear"), gb.Table([-9, 9], [-180.0, 180.0])):
        assert not any(row.times for row in gb.simulate(of(quiet), t_end=1.0).watched.tables)


@pytest.mark.long
def test_rows_of_a_loss_table_are_watched_where_the_housing_stands_still() -> None:
    rig = gb.Drivetrain("losses")
    gear = rig.add("gear", gb.LossyGear(ratio=2, loss_table=((0, 0.9, 0.9, 0, 0), (1, 0.8, 0.8, 0, 0))))
    rig.chain(
        rig.add("drive", gb.Torque(tau=5.0)), rig.add("one", gb.Inertia(J=1.0)), gear, rig.add("two", gb.Inertia(J=1.0))
    )
    with pytest.warns(gb.GearblocksWarning, match=r"'gear\.loss_table' is left first at 0\.2.*draw its last row on"):
        gb.simulate(rig, t_end=1.0)
    rig.connect(rig.add("case", gb.Inertia(J=10.0)).a, gear.housing)
    assert gb.simulate(rig, t_end=1.0).watched.tables == ()


@pytest.mark.long
def test_tables_of_the_parts_of_a_composite_block_are_watched() -> None:
    rig = gb.Drivetrain("box of losses")
    box = gb.Gearbox(ratio=2, loss_table=((0, 0.9, 0.9, 0, 0), (1, 0.8, 0.8, 0, 0)), k=1e4, c=1.0)
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=1.0))
    rig.chain(rig.add("drive", gb.Torque(tau=5.0)), one, rig.add("box", box), two)
    with pytest.warns(gb.GearblocksWarning, match=r"'box\.gear\.loss_table' is left first"):
        gb.simulate(rig, t_end=1.0)


@pytest.fixture(scope="module")
def scenes() -> dict[str, Any]:
    if not SCENES.exists():
        pytest.skip("the scenes are not here")
    return runpy.run_path(str(SCENES))


@pytest.fixture
def quiet() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gb.GearblocksWarning)
        yield


def _pair(load: Any, *, c: float = 100.0, mesh: dict[str, Any] | None = None) -> gb.Drivetrain:
    """Two gears, the first one driven against a load."""
    rig = gb.Drivetrain("pair")
    pinion, wheel = rig.add("pinion", gb.Inertia(J=1e-3)), rig.add("wheel", gb.Inertia(J=4e-3))
    values = {"k": 1e8, "c": c, "backlash": gb.Backlash(half_gap=5e-5), **(mesh or {})}
    block = gb.GearMesh(teeth=(20, 40), external=True, module=2e-3, pressure_angle=0.35, **values)
    drive, load = rig.add("drive", gb.Torque(tau=load)), rig.add("drag", gb.Damper(c=0.05))
    rig.chain(drive, pinion, rig.add("mesh", block), wheel, load, rig.add("case", gb.Fixed()))
    return rig


@pytest.mark.long
def test_the_rattle_says_how_often_its_teeth_would_have_parted(scenes: dict[str, Any]) -> None:
    plain = scenes["rattle"]().without("mesh.backlash")
    with pytest.warns(
        gb.GearblocksWarning, match=r"'mesh.backlash' was left out and would have acted 385 times"
    ) as said:
        run = gb.simulate(plain, t_end=1.0)
    assert len(said) == 1
    (row,) = run.watched
    assert (row.effect, row.output, row.times) == ("mesh.backlash", "mesh.force", 385)
    located = [
        e.t for e in run.events if e.component == "mesh.switch 3"
    ]  # abs(N) of the friction has its corners there
    assert row.times == len(located)
    assert row.first == pytest.approx(located[0], abs=1e-5)  # less than a step
    assert row.low == pytest.approx(run["mesh.force"].min())
    assert row.low < 0 < row.high


@pytest.mark.long
def test_the_whine_stays_silent(scenes: dict[str, Any]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = gb.simulate(scenes["whine"]().without("mesh.backlash"), t_end=0.4, initial="static")
    assert run.watched[0].times == 0
    assert run.watched[0].low == pytest.approx(run["mesh.force"].min(), rel=1e-3)
    assert run.watched[0].low > 3168


@pytest.mark.usefixtures("quiet")
def test_steps_are_watched_and_not_samples(scenes: dict[str, Any]) -> None:
    plain = scenes["rattle"]().without("mesh.backlash")
    by_steps, by_samples = gb.simulate(plain, t_end=0.1), gb.simulate(plain, t=np.linspace(0.0, 0.1, 3))
    assert by_steps.watched == by_samples.watched


@pytest.mark.usefixtures("quiet")
@pytest.mark.parametrize("method", ["dp8", "dp5", "rodas", "rk4"])
@pytest.mark.parametrize("gone", ["mesh.backlash", "mesh.*"])
def test_outputs_are_those_of_the_run_at_every_step(gone: str, method: str) -> None:
    step = {"step": 2e-4} if method == "rk4" else {}
    mesh = (
        {"stiffness_variation": gb.Square(ripple=0.2, contact_ratio=1.4, driven_by=150.0)}
        if gone == "mesh.backlash"
        else {}
    )
    rig = _pair(1 + 5 * gb.sin(40 * gb.time), mesh=mesh).without(gone)
    run = gb.simulate(rig, t_end=0.3, method=method, **step)
    (row,) = [x for x in run.watched if x.effect == "mesh.backlash"]
    force = run[row.output]
    assert run.stats.events or not mesh
    assert (row.low, row.high) == (force.min(), force.max())
    assert row.times == np.count_nonzero(np.diff(np.sign(force[np.abs(force) > 1e-4 * np.abs(force).max()])))


@pytest.mark.usefixtures("quiet")
def test_a_watch_changes_nothing_of_the_run_and_can_be_switched_off() -> None:
    plain = _pair(5 * gb.sin(40 * gb.time)).without("mesh.backlash")
    watched, bare = gb.simulate(plain, t_end=0.3), gb.simulate(plain, t_end=0.3, watch=False)
    assert watched.watched.active
    assert not bare.watched
    assert np.array_equal(watched["mesh.force"], bare["mesh.force"])
    assert watched.stats.steps == bare.stats.steps


@pytest.mark.long
@pytest.mark.usefixtures("quiet")
@pytest.mark.parametrize("seed", range(6))
def test_changes_of_sign_are_those_of_a_fine_look_but_for_dips_within_a_step(seed: int) -> None:
    random = np.random.default_rng(seed)
    low, high = sorted(random.uniform(20, 400, 2))
    load = random.uniform(-1, 1) + 3 * gb.sin(low * gb.time) + 2 * gb.sin(high * gb.time)
    run = gb.simulate(_pair(load).without("mesh.backlash"), t_end=0.4)
    times = np.linspace(0.0, 0.4, 200_001)
    force = gb.simulate(_pair(load).without("mesh.backlash"), t=times, watch=False)["mesh.force"]
    side = np.sign(force[np.abs(force) > 1e-5 * np.abs(force).max()])
    missed = np.count_nonzero(np.diff(side)) - run.watched[0].times
    assert missed % 2 == 0
    assert 0 <= missed <= 0.1 * len(side[1:][np.diff(side) != 0])


@pytest.mark.long
def test_rigid_teeth_are_watched_by_the_force_that_keeps_them_together(quiet: None) -> None:
    run = gb.simulate(_pair(5 * gb.sin(40 * gb.time)).without("mesh.*"), t_end=0.3)
    rows = [x for x in run.watched if x.effect == "mesh.backlash"]
    assert rows[0].times == 3  # sin(40 t) itself, up to the inertia's phase


@pytest.mark.long
def test_a_belt_without_creep_says_that_it_would_have_slid() -> None:
    rig = gb.Drivetrain("belt")
    belt = rig.add("belt", gb.BeltDrive(ratio=0.5, slip=gb.Creep(stiffness=2e3, low_speed=1.0, limit=40.0)))
    motor, fan = rig.add("motor", gb.Inertia(J=0.1)), rig.add("fan", gb.Inertia(J=0.4))
    rig.chain(rig.add("drive", gb.Torque(tau=60 * gb.sin(5 * gb.time))), motor, belt, fan)
    with pytest.warns(gb.GearblocksWarning, match="'belt.slip' was left out and would have acted"):
        run = gb.simulate(rig.without("belt.slip"), t_end=2.0)
    torque = np.abs(run["belt.torque"])
    assert run.watched[0].times == np.count_nonzero(np.diff((torque > 20.0).astype(int)) == 1)


class Snubber(gb.Block):
    """A damper with a dry part in parallel, which a user takes away."""

    a, b = gb.Flange("left"), gb.Flange("right")
    c: float = gb.param("damping", "N m s/rad")
    dry: gb.Stribeck | None = gb.effect("more torque at rest", default=None)

    def physics(self, s: Any) -> Iterator[Any]:
        rate = s.b.w - s.a.w
        torque = s.c * rate if self.dry is None else s.c * rate + s.dry.rise * rate / s.dry.speed
        yield gb.Force(s.b.phi - s.a.phi, torque)
        yield gb.Shows("torque", torque, "N m")

    def would_show(self, effect: str) -> Iterator[gb.Watch]:
        if effect == "dry" and self.dry is not None:
            yield gb.Watch("torque", "the torque exceeds what the dry part takes", self.dry.rise)


def test_a_block_of_a_user_declares_what_shows_its_effects() -> None:
    rig = gb.Drivetrain("snubber")
    snubber = rig.add("snubber", Snubber(c=0.5, dry=gb.Stribeck(rise=2.0, speed=10.0)))
    disc = rig.add("disc", gb.Inertia(J=0.01, w0=10.0))
    rig.chain(rig.add("wall", gb.Fixed()), snubber, disc)
    with pytest.warns(gb.GearblocksWarning, match="'snubber.dry' was left out and would have acted once at 0 s"):
        run = gb.simulate(rig.without("snubber.dry"), t_end=0.1)
    assert run.watched[0].high == pytest.approx(5.0)


def _excited(w: float) -> gb.Drivetrain:
    rig = gb.Drivetrain("two discs")
    left, right = rig.add("left", gb.Inertia(J=0.02)), rig.add("right", gb.Inertia(J=0.05))
    shaft, drive = rig.add("shaft", gb.Shaft(k=2.0e4, c=3.0)), rig.add("drive", gb.Torque(tau=gb.sin(w * gb.time)))
    rig.chain(drive, left, shaft, right)
    return rig.without("shaft.compliance")


@pytest.mark.long
def test_a_frequency_near_the_mode_of_a_shaft_made_rigid_is_said() -> None:
    natural = np.sqrt(2.0e4 * (1 / 0.02 + 1 / 0.05))
    with pytest.warns(
        gb.GearblocksWarning, match="'shaft.compliance' was left out .* near its natural frequency of 188.3 Hz"
    ):
        run = gb.simulate(_excited(0.95 * natural), t_end=0.1)
    assert [x.times for x in run.watched] == [1]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = gb.simulate(_excited(0.5 * natural), t_end=0.1)
    assert [(x.times, x.effect) for x in run.watched] == [(0, "shaft.compliance")]
    assert run.watched.unwatched == ("shaft.damping",)


@pytest.mark.usefixtures("quiet")
def test_modes_that_went_are_looked_for_once_and_kept_for_other_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    model = gb.build(_excited(812.0))
    first = gb.simulate(model, t_end=0.05).watched

    def never(*_: Any) -> Any:
        raise AssertionError

    monkeypatch.setattr(resonances, "_found", never)
    assert gb.simulate(_excited(812.0), t_end=0.05).watched == first
    monkeypatch.setattr(resonances, "_known", {})  # as in another process
    assert gb.simulate(model, t_end=0.05).watched == first
    assert [row.effect for row in first] == ["shaft.compliance"]


@pytest.mark.long
def test_a_run_up_meets_the_mode_when_its_mesh_frequency_does() -> None:
    rig = gb.Drivetrain("run-up")
    ramp = gb.Speed(w=gb.Table([0.0, 1.0], [0.0, 150.0]))
    pair = gb.GearMesh(
        teeth=(20, 40), external=True, module=2e-3, pressure_angle=0.35, k=1e8, c=100.0,
        stiffness_variation=gb.Fourier(cos=(0.1,)),
    )  # fmt: skip
    pinion, wheel = rig.add("pinion", gb.Inertia(J=1e-3)), rig.add("wheel", gb.Inertia(J=4e-3))
    load, disc = rig.add("soft", gb.Shaft(k=1.6e4, c=1.0)), rig.add("disc", gb.Inertia(J=0.05))
    rig.chain(rig.add("motor", ramp), pinion, rig.add("mesh", pair), wheel, load, disc)
    with pytest.warns(gb.GearblocksWarning, match="soft.compliance"):
        run = gb.simulate(rig.without("soft.compliance"), t_end=1.0)
    (row,) = [x for x in run.watched if x.effect == "soft.compliance"]
    natural = gb.modes(rig).frequencies[0]  # 85 Hz: the disc against the wheel
    assert row.times == 1
    assert row.first == pytest.approx(0.8 * natural / (20 * 150.0), rel=0.02)


@pytest.mark.long
def test_what_was_left_out_is_known_through_further_changes_and_inside_trains(quiet: None) -> None:
    plain = _pair(5 * gb.sin(40 * gb.time)).without("mesh.backlash").set({"mesh.k": 2e8}).without("mesh.damping")
    assert plain.left_out().names == ("mesh.damping", "mesh.backlash")
    whole = gb.Drivetrain("whole")
    whole.add("stage", plain)
    run = gb.simulate(whole, t_end=0.3)
    assert [(x.effect, x.output) for x in run.watched] == [("stage.mesh.backlash", "stage.mesh.force")]
    assert _pair(1.0).left_out() is None


def test_the_c_is_that_of_a_train_built_without_and_the_model_watches() -> None:
    plain = _pair(5 * gb.sin(40 * gb.time)).without("mesh.backlash")
    model, built = gb.build(plain), gb.build(_pair(5 * gb.sin(40 * gb.time), mesh={"backlash": None}))
    assert model.program.source == built.program.source
    assert "backlash" not in model.program.source
    with pytest.warns(gb.GearblocksWarning, match="mesh.backlash"):
        gb.simulate(model, t_end=0.3)
    assert not gb.simulate(built, t_end=0.3).watched
    assert pickle.loads(pickle.dumps(model)).left_out is None


@pytest.mark.long
def test_a_train_at_rest_warns_of_nothing() -> None:
    rig = _pair(0.0).without("mesh.backlash")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gb.simulate(rig, t_end=0.1)


@pytest.mark.usefixtures("quiet")
def test_what_was_watched_reads_as_text_and_table_and_stays_with_the_run() -> None:
    run = gb.simulate(_pair(5 * gb.sin(40 * gb.time)).without("mesh.backlash", "mesh.damping"), t_end=0.3)
    assert "mesh.backlash: " in str(run.watched)
    assert str(run.watched).endswith("not watched: mesh.damping")
    assert "<table" in run.watched._repr_html_()
    assert pickle.loads(pickle.dumps(run)).watched == run.watched
    assert run.select("mesh.*").watched == run.watched
