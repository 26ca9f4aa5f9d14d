"""Energy of every block in a small train, forward and in reverse: what it stores in closed form, what it loses as its
output says, and that stored energy, loss, supply and the work through its flanges balance, by points of Gauss."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

import gearblocks as gb

pytestmark = pytest.mark.filterwarnings("ignore:.*is left first")  # tables that are held on purpose

T, SIGN = gb.time, gb.Parameter("direction", 1.0)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)
MESH = {"teeth": (23, 41), "r_base": (0.03, 0.03 * 41 / 23), "external": True, "k": 2e5, "c": 30.0}
TEETH = {"teeth": (23, 41), "external": True, "module": 3e-3, "pressure_angle": 0.35, "k": 2e5, "c": 30.0}
GAP = gb.Backlash(half_gap=3e-4)
ELLIPSE, SPRING = gb.RatioLaw.ellipse(e=0.3), gb.Shaft(k=20.0, c=0.8)


@dataclass
class Case:
    """A block between two bodies, or on one: flanges; start speeds; stored energy from outputs; parts of the ledger."""

    block: gb.Block
    flanges: tuple[str, ...] = ("a", "b")
    speeds: tuple[float, float] = (0.0, 0.0)
    stored: Callable | None = None
    parts: str = ""  # of "in" and "out", those that the ledger has
    shows: str = "loss_power"
    drive: object = SIGN * (3 + 5 * gb.sin(7 * T))
    load: gb.Block = SPRING


def _twist(k):
    return lambda run: k * run["el.twist"] ** 2 / 2


def _gap(k, half, x="deflection"):
    return lambda run: k * np.maximum(np.abs(run[f"el.{x}"]) - half, 0) ** 2 / 2


def _polynomial(run):
    return 50 * run["el.twist"] ** 2 + 2500 * run["el.twist"] ** 4


CASES = {
    "shaft": Case(gb.Shaft(k=300.0, c=0.5), stored=_twist(300), parts="out"),
    "shaft over time": Case(gb.Shaft(k=300 * (1 + 0.3 * gb.sin(40 * T)), c=0.5), parts="in out"),
    "shaft of third power": Case(gb.Shaft(torque=100 * gb.twist + 1e4 * gb.twist**3, c=0.5), stored=_polynomial, parts="out"),
    "slider": Case(gb.Shaft(k=300.0, hysteresis=gb.Hysteresis(friction=2.0)), stored=_twist(300), parts="out"),
    "slider and spring": Case(
        gb.Shaft(k=300.0, hysteresis=gb.Hysteresis(friction=2.0, stiffness=150.0)), parts="out",
        stored=lambda run: 150 * run["el.twist"] ** 2 + (run["el.torque"] + 300 * run["el.twist"]) ** 2 / 300,
    ),
    "damper": Case(gb.Damper(c=2.0), parts="out"),
    **{
        f"lash {how}": Case(
            gb.Lash(k=2e3, half_gap=0.02, c=3.0, contact_damping=how), stored=_gap(2e3, 0.02, "twist"), parts="out"
        )
        for how in ("clipped", "clipped_force", "always")
    },
    "lash, impacts": Case(
        gb.Lash(k=2e3, half_gap=0.02, contact_damping=gb.HuntCrossley(restitution=0.6)), parts="out",
        stored=_gap(2e3, 0.02, "twist"),
    ),
    "mesh": Case(gb.GearMesh(**MESH), ("pinion", "wheel"), stored=_gap(2e5, 0), parts="out"),
    "mesh over the angle": Case(
        gb.GearMesh(**MESH, stiffness_variation=gb.Fourier(cos=(0.2,)), transmission_error=gb.Harmonic(sin=(1e-5,))),
        ("pinion", "wheel"), stored=lambda run: run["el.stiffness"] * run["el.deflection"] ** 2 / 2, parts="out",
    ),
    "mesh over time": Case(
        gb.GearMesh(**MESH, stiffness_variation=gb.Fourier(cos=(0.2,), driven_by=50.0), backlash=GAP),
        ("pinion", "wheel"), parts="in out",
    ),
    "mesh, square wave": Case(
        gb.GearMesh(**MESH, friction=gb.ToothFriction(mu=0.1, direction="square_wave", wave=gb.sin(30 * T))),
        ("pinion", "wheel"), stored=_gap(2e5, 0), parts="in out", shows="",
    ),
    "mesh, sliding teeth": Case(
        gb.GearMesh(**TEETH, friction=gb.ToothFriction(mu=0.1, transition=0.1)), ("pinion", "wheel"), (2.0, -2.0 * 23 / 41),
        stored=_gap(2e5, 0), parts="out", shows="",
    ),
    "spline": Case(
        gb.SplineCoupling(teeth=3, radius=0.03, k=2e5, c=20.0, backlash=gb.Backlash(half_gap=3e-4)),
        stored=_gap(2e5, 3e-4), parts="out",
    ),
    "clutch": Case(gb.Clutch(capacity=2.0), parts="out"),
    "clutch over slip": Case(
        gb.Clutch(mu=gb.Table([-1, 1, 10], [0.5, 0.4, 0.3]), force_max=8.0, engagement=0.5 + 0.4 * gb.sin(6 * T)), parts="out"
    ),
    "one way": Case(gb.OneWayClutch(mu=0.5, force_max=3.0, engagement=0.3 + gb.sin(6 * T)), parts="out"),
    "freewheel": Case(gb.Freewheel(), parts="out"),
    "synchroniser": Case(gb.Synchronizer(capacity=4 + gb.sin(9 * T), engaged=T - 0.7), speeds=(3.0, 0.0), parts="out"),
    "lossy gear": Case(
        gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.8), bearing=(0.1, 0.2)), drive=SIGN * (3 + 0.5 * gb.sin(3 * T)),
        load=gb.Damper(c=0.8), parts="out",
    ),
    "lossy table": Case(
        gb.LossyGear(ratio=2.0, loss_table=((0.0, 0.9, 0.8, 0.1, 0.2), (5.0, 0.95, 0.9, 0.2, 0.3))),
        drive=SIGN * (3 + 0.5 * gb.sin(3 * T)), load=gb.Damper(c=0.8), parts="out",
    ),
    "ideal gear": Case(gb.IdealGear(ratio=-2.5)),
    "ratio law": Case(gb.NonCircularGear(law=ELLIPSE, external=False)),
    "ratio law, compliant": Case(
        gb.NonCircularGear(law=ELLIPSE, external=True, k=2e3, c=2.0, backlash=gb.Backlash(half_gap=0.01)),
        stored=_gap(2e3, 0.01), parts="out",
    ),
    "moving phase": Case(
        gb.NonCircularGear(law=ELLIPSE, external=False, phase=0.3 * (1 - gb.cos(4 * T)), k=2e3, c=2.0), stored=_gap(2e3, 0),
        parts="in out",
    ),
    "universal joint": Case(gb.UniversalJoint(angle=0.4)),
    "belt": Case(
        gb.BeltDrive(ratio=2.0, slip=gb.Creep(stiffness=100.0, low_speed=0.5, limit=4.0)), speeds=(4.0, 2.0), parts="out"
    ),
    "converter": Case(
        gb.TorqueConverter(
            capacity=gb.Table([0, 0.5, 0.9, 1.0], [0.02, 0.018, 0.01, 0.0]), ratio=gb.Table([0, 0.9, 1.0], [2.0, 1, 1])
        ), ("impeller", "turbine"), (10.0, 2.0), drive=SIGN * 8, parts="out",
    ),
    "brake": Case(gb.Brake(capacity=1 + 2 * gb.sin(3 * T)), ("a",), parts="out"),
    "bearing": Case(
        gb.BearingFriction(coulomb=1.0, viscous=0.1, stribeck=gb.Stribeck(rise=0.3, speed=2.0)), ("a",), parts="out"
    ),
    "speed load": Case(gb.SpeedLoad(coeffs=(1.0, 0.2, 0.05)), ("flange",), parts="out"),
    "eddy currents": Case(
        gb.EddyCurrentBrake(tau_nominal=3.0, w_nominal=2.0, excitation=0.5 + 0.4 * gb.sin(3 * T)), ("flange",), parts="out"
    ),
    "engine": Case(
        gb.Engine(
            torque_map=gb.Table2([-50.0, 0.0, 50.0], [0.0, 1.0], [[1, 4], [0, 5], [-1, 6]]),
            throttle=0.5 + 0.4 * gb.sin(3 * T),
        ), ("flange",), (3.0, 0.0), parts="in", shows="",
    ),
    "motor": Case(
        gb.DCMotor(R=0.5, L=0.01, k=0.3, u=SIGN * (10 + 5 * gb.sin(20 * T))), ("flange",), parts="in out", shows="",
        stored=lambda run: 0.01 * run["el.current"] ** 2 / 2,
    ),
    "vehicle": Case(
        gb.Vehicle(mass=5.0, wheel_radius=0.3, drag_area=0.7, rolling=0.01, rolling_speed=0.1, tyre=gb.TyreSlip(
            stiffness=50.0, grip=0.9, low_speed=0.5)), ("flange",), parts="out", shows="",
        stored=lambda run: 2.5 * run["el.v"] ** 2,
    ),
    "vehicle on a slope": Case(
        gb.Vehicle(mass=5.0, wheel_radius=0.3, drag_area=0.7, rolling=0.01, grade=0.05 * gb.sin(2 * T)), ("flange",),
        stored=lambda run: 2.5 * (0.3 * run["one.w"]) ** 2, parts="in out", shows="",
    ),
    "vehicle in the wind": Case(
        gb.Vehicle(mass=5.0, wheel_radius=0.3, wheel_inertia=0.02, drag_area=0.7, wind=SIGN * 4 * gb.sin(3 * T)), ("flange",),
        stored=lambda run: (2.5 * 0.3**2 + 0.01) * run["one.w"] ** 2, parts="in out", shows="",
    ),
    "acceleration": Case(
        gb.Acceleration(alpha=SIGN * gb.piecewise((3, T < 0.6), (-1, True))), ("flange",), parts="in", shows=""
    ),
    "angle and its rates": Case(
        gb.Angle(phi=SIGN * 0.5 * gb.sin(6 * T), w=SIGN * 3 * gb.cos(6 * T), alpha=-SIGN * 18 * gb.sin(6 * T)), ("flange",),
        parts="in", shows="",
    ),
    "torque": Case(
        gb.Torque(tau=SIGN * gb.piecewise((2, gb.sense("one.phi") * SIGN < 0.1), (-1, True))), ("flange",), parts="in", shows=""
    ),
    "speed": Case(gb.Speed(w=SIGN * (3 + 2 * gb.sin(9 * T))), ("flange",), parts="in", shows=""),
    "angle": Case(gb.Angle(phi=SIGN * 0.5 * gb.sin(6 * T)), ("flange",), parts="in", shows=""),
    "filtered speed": Case(
        gb.Speed(w=SIGN * gb.piecewise((3, T < 0.6), (-1, True)), filter=20.0), ("flange",), parts="in", shows=""
    ),
}  # fmt: skip
MANY = {
    "slider",
    "one way",
    "lossy table",
    "ratio law, compliant",
    "vehicle on a slope",
    "speed",
    "shaft of third power",
    "mesh over time",
    "shaft over time",
    "lash clipped_force",
    "lash always",
    "synchroniser",
    "clutch over slip",
    "engine",
}

LOPSIDED = {"one way", "freewheel", "ratio law", "ratio law, compliant", "moving phase", "vehicle on a slope", "engine"}
LOPSIDED |= {"mesh over the angle", "mesh over time", "mesh, sliding teeth"}
"""Those whose law tells forward from reverse."""


def _train(case):
    """drive - body one - [shaft - ] block - body two - load; a block on one flange lies beside a shaft to a second body."""
    rig = gb.Drivetrain("energy")
    drive, one, two = gb.Torque(tau=case.drive), gb.Inertia(J=0.4), gb.Inertia(J=0.7)
    drive, one, two = rig.add("drive", drive), rig.add("one", one), rig.add("two", two)
    block, load, ground = rig.add("el", case.block), rig.add("load", case.load), rig.add("ground", gb.Fixed())
    prescribed = isinstance(case.block, (gb.Speed, gb.Angle))
    rig.connect(drive.flange, two.b if prescribed else one.a)
    rig.connect(one.b, getattr(block, case.flanges[0]))
    if len(case.flanges) > 1:
        rig.connect(getattr(block, case.flanges[1]), two.a)
    else:
        rig.chain(one, rig.add("shaft", gb.Shaft(k=60.0, c=0.3)), two)
    rig.chain(two, load, ground)
    return rig


def _integrals(model, run, **arguments):
    """Integrals over a run of powers: of every block into its flanges, and of the output loss_power of the block."""
    starts, ends = run.t[:-1], run.t[1:]
    keep = ends - starts > 1e-12 * ends  # between events that rounding alone tells apart nothing flows
    mid, half = (starts + ends)[keep] / 2, (ends - starts)[keep] / 2
    inner = gb.simulate(model, t=(mid[:, None] + half[:, None] * NODES).ravel(), **arguments)
    found = {}
    for name in inner.names:
        if name.endswith(".power"):
            element = name.rsplit(".", 2)[0]
            found[element] = found.get(element, 0.0) + half @ (inner[name].reshape(-1, len(NODES)) @ WEIGHTS)
    for shown in ("loss_power", "electric_power"):
        if f"el.{shown}" in inner.names:
            found[shown] = half @ (inner[f"el.{shown}"].reshape(-1, len(NODES)) @ WEIGHTS)
    return found


ON_FLANGE = {
    "torque on flange b": ("b", 1), "torque on the flange": ("flange", 1), "reaction on the flange": ("flange", 1),
    "braking torque, positive against forward rotation": ("a", -1), "torque that enters at flange a": ("a", -1),
    "torque on the turbine": ("turbine", 1), "torque that the impeller takes": ("impeller", -1),
}  # fmt: skip


def _shown_torques(model, run):
    """Every torque that the block shows is the one on that flange."""
    for q in model.program.outputs:
        if q.name.startswith("el.") and q.words in ON_FLANGE:
            flange, sign = ON_FLANGE[q.words]
            true = sign * run[f"el.{flange}.tau"]
            assert np.abs(run[q.name] - true).max() <= 1e-9 * np.abs(true).max(), q.name


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.long) if n in MANY else n for n in CASES])
@pytest.mark.few(2)
def test_stored_lost_and_supplied_energy_of_a_block_are_what_flows_through_it(name):
    case = CASES[name]
    model = gb.build(_train(case))
    for method, rtol in (("dp8", 1e-10), ("dp5", 1e-6), ("rodas", 1e-6)):
        worth = {}
        for sign in (1.0, -1.0):
            moving = {f"{n}.w": sign * w for n, w in zip(("one", "two"), case.speeds, strict=True) if w}
            arguments = {"method": method, "rtol": rtol, "parameters": {"direction": sign}, "initial": moving or None}
            run = gb.simulate(model, t_end=1.5, **arguments)
            ledger, flows = run.energy, _integrals(model, run, **arguments)
            # points of Gauss along polynomials of an order below that of the steps
            near = 40 * rtol * ledger.turnover
            assert ledger.residual <= 5 * rtol
            gone, given = ledger.dissipated.get("el", 0.0), ledger.supplied.get("el", 0.0)
            has = {part for part, x in (("in", ledger.supplied), ("out", ledger.dissipated)) if "el" in x}
            assert has == set(case.parts.split())
            assert gone >= -near
            at_end, at_start = ledger.stored.get("el", 0.0), 0.0
            if case.stored is not None:
                assert at_end == pytest.approx(case.stored(run)[-1], abs=near / 10, rel=1e-9)
                at_start = case.stored(run)[0]
            elif "el" in ledger.stored:
                at_start = ledger.start - sum(0.2 * w**2 if n == "one.w" else 0.35 * w**2 for n, w in moving.items())
            assert abs(at_end - at_start + gone - given + flows["el"]) < near
            if "out" in case.parts and case.shows:
                assert abs(flows["loss_power"] - gone) < near
            if "electric_power" in flows:
                assert abs(flows["electric_power"] - given) < near
            _shown_torques(model, run)
            worth[sign] = (gone, given, at_end)
        if name not in LOPSIDED:
            assert worth[-1.0] == pytest.approx(worth[1.0], abs=near)


@pytest.mark.parametrize(("lower", "upper", "e"), [(-0.1, 0.1, 0.5), (-0.3, 0.05, 0.8), (-0.05, 0.02, 0.0)])
@pytest.mark.few(1)
def test_impacts_on_stops_lose_what_their_restitution_says(lower, upper, e):
    rig = gb.Drivetrain("stops")
    body, drive = rig.add("one", gb.Inertia(J=0.5)), rig.add("drive", gb.Torque(tau=3 + 20 * gb.sin(9 * T)))
    rig.chain(drive, body, rig.add("el", gb.HardStop(lower=lower, upper=upper, restitution=e)))
    rig.chain(body, rig.add("spring", gb.Shaft(k=3.0)), rig.add("wall", gb.Fixed()))
    for method, rtol in (("dp8", 1e-9), ("dp5", 1e-6)):
        run = gb.simulate(rig, t_end=2.0, method=method, rtol=rtol)
        hits = [x for x in run.events if x.kind == "impact" and x.component.startswith("el")]
        lost = sum(0.25 * (x.before**2 - x.after**2) for x in hits)
        assert len(hits) > 5 and run.energy.residual <= 5 * rtol
        assert run.energy.dissipated["el"] == pytest.approx(lost, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("J", [(0.5, 2.0), (3.0, 0.1)])
def test_a_dog_that_closes_loses_the_energy_of_the_difference(J):
    rig = gb.Drivetrain("dog")
    one, two = rig.add("one", gb.Inertia(J=J[0], w0=9.0)), rig.add("two", gb.Inertia(J=J[1], w0=-4.0))
    rig.chain(one, rig.add("el", gb.DogClutch(engaged=T - 0.5)), two)
    run = gb.simulate(rig, t_end=1.0)
    assert run.energy.dissipated["el"] == pytest.approx(J[0] * J[1] / sum(J) / 2 * 13.0**2, rel=1e-12)
    assert run.energy.residual < 1e-12
