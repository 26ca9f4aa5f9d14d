"""Trains in files: what is written comes back, and what is damaged, foreign or no train is refused by name."""

import json
import re
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.train.handles import FlangeHandle

pytestmark = pytest.mark.filterwarnings("ignore:.*is left first")  # tables that are held on purpose
NAN = float("nan")

# -- JSON -------------------------------------------------------------------------------------------------------------

P = gb.Parameter("P", 0.7)
QUICK = (
    "DogClutch",
    "Lash that hits",
    "Shaft of an expression",
    "Fixed",
    "IdealGear",
    "GearMesh with jumps",
    "BearingFriction",
)
"""Those that differ most."""

BLOCKS = {
    "Inertia": gb.Inertia(J=2 * P, phi0=0.1, w0=3.0),
    "Fixed": gb.Fixed(phi0=0.3),
    "Shaft": gb.Shaft(k=200.0, damping_ratio=0.1),
    "Shaft of an expression": gb.Shaft(torque=100 * gb.twist + P * sp.Abs(gb.twist) * gb.twist, c=0.1),
    "Shaft of a table": gb.Shaft(torque=gb.Table([-2, 0, 1, 2], [-20, 0, 15, 50], "cubic")),
    "Shaft of segments": gb.Shaft(k=200.0, J=0.2, segments=3, c=0.01),
    "Damper": gb.Damper(c=P),
    "Lash": gb.Lash(k=300.0, half_gap=0.02, c=1.0, contact_damping="clipped_force"),
    "IdealGear": gb.IdealGear(teeth=(20, 33), external=True),
    "IdealGear of a ratio": gb.IdealGear(ratio=-0.3),
    "GearMesh": gb.GearMesh(
        teeth=(20, 33), module=0.1, pressure_angle=0.35, helix_angle=0.1, external=False, k=300.0, c=1.0,
        stiffness_variation=gb.Fourier(cos=(0.1, P), sin=(0.05,), phase=0.3), backlash=gb.Backlash(half_gap=0.02),
        contact_damping="always", transmission_error=gb.Harmonic(cos=(0.01,), driven_by=5.0 + gb.sin(gb.time)),
    ),
    "GearMesh with jumps": gb.GearMesh(
        teeth=(20, 33), r_base=(1.0, 1.65), external=True, k=300.0,
        stiffness_variation=gb.Square(ripple=0.1, contact_ratio=1.4, driven_by=gb.Input("w", 7.0)),
    ),
    "SplineCoupling": gb.SplineCoupling(teeth=12, radius=1.5, k=300.0, backlash=gb.Backlash(half_gap=0.02)),
    "Torque": gb.Torque(tau=sp.Piecewise((P, gb.time < 0.3), (gb.Table([0, 1], [2, 3]), True)) * gb.sense("one.w")),
    "SpeedLoad": gb.SpeedLoad(coeffs=(0.1, 0.2, P)),
    "Clutch": gb.Clutch(capacity=P * (1 + gb.sin(5 * gb.time)), peak=1.2),
    "Clutch over slip": gb.Clutch(mu=gb.Table([0, 2], [0.5, 0.4]), force_max=4.0, engagement=P, geometry=1.5),
    "Brake": gb.Brake(mu=0.4, force_max=4.0, engagement=gb.sense("one.w")),
    "BearingFriction": gb.BearingFriction(coulomb=0.1, viscous=P, stribeck=gb.Stribeck(rise=0.1, speed=0.5)),
    "BearingFriction of a table": gb.BearingFriction(torque=gb.Table([0, 2], [0.5, 0.4]), peak=1.1),
    "OneWayClutch": gb.OneWayClutch(mu=0.4, force_max=4.0, engagement=P - gb.time),
    "Freewheel": gb.Freewheel(),
    "DogClutch": gb.DogClutch(engaged=gb.time - 0.5),
    "Synchronizer": gb.Synchronizer(capacity=P, engaged=gb.Input("ask", 1.0)),
    "HardStop": gb.HardStop(lower=-0.3, upper=P, restitution=0.5),
    "Shaft with inner friction": gb.Shaft(k=200.0, hysteresis=gb.Hysteresis(friction=1.0, stiffness=P)),
    "Lash that hits": gb.Lash(k=1.0, half_gap=0.1, contact_damping=gb.HuntCrossley(restitution=0.5)).changed(k=None),
}  # fmt: skip


def _around(block):
    """A small train with the block in it."""
    rig = gb.Drivetrain("around")
    one, drive = rig.add("one", gb.Inertia(J=1.0, w0=None)), rig.add("drive", gb.Torque(tau=3.0))
    part = rig.add("part", block)
    if (len(rig.add("spare", gb.Inertia(J=2.0)).flanges) and len(type(block).flanges) == 1) or isinstance(
        block, gb.Torque
    ):
        shaft = rig.add("shaft", gb.Shaft(k=50.0))
        rig.chain(drive, one, shaft, part)
        rig.connect(FlangeHandle(rig, "spare", "a"), one.b)
    else:
        rig.chain(drive, one, part)
        rig.connect(FlangeHandle(rig, "spare", "a"), FlangeHandle(rig, "part", part.flanges[1]))
    return rig


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.long) if name not in QUICK else name
        for name in BLOCKS
        if name not in ("Torque", "SpeedLoad")
    ],
)
@pytest.mark.few(1)
def test_a_train_survives_the_way_through_json(name, tmp_path):
    _same_after_json(_around(BLOCKS[name]), tmp_path)


@pytest.mark.parametrize("name", ["Torque", "SpeedLoad"])
@pytest.mark.few(1)
def test_a_source_survives_the_way_through_json(name, tmp_path):
    rig = gb.Drivetrain("source")
    one, part = rig.add("one", gb.Inertia(J=1.0, w0=3.0)), rig.add("part", BLOCKS[name])
    rig.chain(one, part)
    _same_after_json(rig, tmp_path)


def _same_after_json(rig, tmp_path):
    rig.to_json(tmp_path / "train.json")
    back = gb.Drivetrain.from_json(tmp_path / "train.json")
    one, two = gb.build(rig), gb.build(back)
    assert one.program.key == two.program.key
    assert one.program.source == two.program.source
    assert np.array_equal(one.values, two.values)
    a, b = (gb.simulate(m, t=np.linspace(0, 1, 11), rtol=1e-6) for m in (one, two))
    assert all(np.array_equal(a[n], b[n], equal_nan=True) for n in a.names)
    back.to_json(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_text() == (tmp_path / "train.json").read_text()


def test_nested_trains_and_coordinates_survive_the_way_through_json(tmp_path):
    inner = gb.Drivetrain("inner")
    a, s = inner.add("a", gb.Inertia(J=1.0)), inner.add("s", gb.Shaft(k=10.0))
    inner.chain(a, s)
    inner.expose("left", a.a)
    inner.expose("right", s.b)
    rig = gb.Drivetrain("outer")
    part, end = rig.add("part", inner), rig.add("end", gb.Inertia(J=1.0, w0=1.0))
    rig.chain(part, end)
    rig.coordinate("x", 2 * P * (gb.sense("part.a.phi") - gb.sense("end.phi")), "rad")
    _same_after_json(rig, tmp_path)


def test_text_in_a_json_file_is_never_run(tmp_path):
    rig = gb.Drivetrain("source")
    rig.chain(rig.add("one", gb.Inertia(J=1.0)), rig.add("part", gb.Torque(tau=gb.sin(gb.time))))
    rig.to_json(tmp_path / "train.json")
    text = (tmp_path / "train.json").read_text()
    harmful = re.sub(r'"sin\(time\)"', "\"__import__('os').getpid()\"", text)
    assert harmful != text
    (tmp_path / "train.json").write_text(harmful)
    with pytest.raises(gb.GearblocksError, match="expression"):
        gb.Drivetrain.from_json(tmp_path / "train.json")


def _inertia(**more: Any) -> gb.Inertia:
    return gb.Inertia(J=1.0, **more)


def _rig() -> gb.Drivetrain:
    rig = gb.Drivetrain("rig")
    rig.chain(
        rig.add("drive", gb.Torque(tau=gb.Input("tau", start=1.0, unit="N m"))),
        rig.add("motor", gb.Inertia(J=0.02)),
        rig.add("shaft", gb.Shaft(k=1.0e3, c=1.0)),
        rig.add("wheel", gb.Inertia(J=0.1)),
    )
    return rig


def _chain(*blocks: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("chain")
    rig.chain(*(rig.add(f"b{i}", block) for i, block in enumerate(blocks)))
    return rig


def _refused(act: Callable[[], Any], *words: str) -> None:
    with pytest.raises(gb.GearblocksError) as caught:
        act()
    for word in words:
        assert word in str(caught.value), str(caught.value)


# -- files ------------------------------------------------------------------------------------------------------------


def test_a_train_survives_its_file(tmp_path: Path) -> None:
    rig = _rig()
    rig.connect(rig.add("gear", gb.IdealGear(ratio=Fraction(1, 3))).a, rig["wheel"].b)
    rig.to_json(tmp_path / "rig.json")
    again = gb.Drivetrain.from_json(tmp_path / "rig.json")
    assert again.describe() == rig.describe()
    assert again.tree().links == rig.tree().links


def _text(change: Callable[[dict[str, Any]], Any], tmp_path: Path) -> Path:
    path = tmp_path / "rig.json"
    _rig().to_json(path)
    data = json.loads(path.read_text(encoding="utf-8"))
    change(data)
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "change",
    [
        lambda d: d.update(format="x"), lambda d: d.pop("leaves") and None, lambda d: d.update(parts=[1]),
        lambda d: d["parts"].update(motor=None), lambda d: d["parts"]["motor"].pop("type"),
        lambda d: d["parts"]["motor"].update(type="Inertiaa"), lambda d: d["parts"]["motor"].update(type="os"),
        lambda d: d["parts"]["motor"].update(type=3), lambda d: d["parts"].update(motor={"type": "Backlash", "half_gap": 1.0}),
        lambda d: d["parts"]["motor"].update(j=1), lambda d: d["parts"]["motor"].pop("J"),
        lambda d: d["parts"]["motor"].update(J=NAN), lambda d: d["parts"]["motor"].update(J="3"),
        lambda d: d["links"].append(["motor.zz", "shaft.a"]), lambda d: d["links"].append(["motor.a"]),
        lambda d: d["links"].append([]), lambda d: d["links"].append(["motor.a", "motor.a"]), lambda d: d["links"].append(3),
        lambda d: d.update(name=3), lambda d: d["leaves"]["tau"].update(start="x"), lambda d: d["leaves"].update(tau=3),
        lambda d: d.update(coordinates={"x": ["sense('motor.phi')"]}), lambda d: d.update(coordinates={"x": ["time", "rad"]}),
        lambda d: d["parts"]["drive"].update(tau={"expression": "__import__('os').getcwd()"}),
        lambda d: d["parts"]["drive"].update(tau={"expression": 3}),
        lambda d: d["parts"]["drive"].update(tau={"fraction": [1, 0]}),
    ],
)  # fmt: skip
def test_a_damaged_file_is_refused(change: Callable[[dict[str, Any]], Any], tmp_path: Path) -> None:
    path = _text(change, tmp_path)
    _refused(lambda: gb.Drivetrain.from_json(path))


@pytest.mark.parametrize(
    "content", [b"", b"\xff\xfe\x00", b'{"format": "gearblocks tr', b"[]", b"null", b"[" * 100_000]
)
def test_a_file_that_is_no_train_is_refused_by_name(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "rig.json"
    path.write_bytes(content)
    _refused(lambda: gb.Drivetrain.from_json(path), "rig.json")
    _refused(lambda: gb.Drivetrain.from_json(tmp_path / "none.json"), "none.json", "cannot read")


def test_a_file_that_cannot_be_written_keeps_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "rig.json"
    path.write_text("before")

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    _refused(lambda: _rig().to_json(path), "rig.json", "no space left", "the file that was there is unchanged")
    assert path.read_text() == "before"
    _refused(lambda: _rig().to_json(tmp_path / "no" / "rig.json"), "there is no folder")


def test_a_block_that_is_not_of_the_catalogue_cannot_be_stored(tmp_path: Path) -> None:
    class Mine(gb.Block):
        f = gb.Flange("f")

        def physics(self, s: Any) -> Any:
            yield gb.Acts(s.f, 1.0)

    _refused(lambda: _chain(Mine(), _inertia()).to_json(tmp_path / "x.json"), "Mine is no block of the catalogue")
