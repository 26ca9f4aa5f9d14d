"""Composing a train: names, connections, changes and files, right and wrong."""

import json
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

import gearblocks as gb
from gearblocks.train.handles import Handle

NAN = float("nan")


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


@pytest.mark.parametrize("name", ["a b", "", 3, None, "1a", "a.b", "a-b", "lump[0]"])
def test_a_part_has_a_plain_name(name: Any) -> None:
    _refused(lambda: gb.Drivetrain("r").add(name, _inertia()), f"part name {name!r} must be a word")


@pytest.mark.parametrize("name", ["", None, 3, " "])
def test_a_drivetrain_has_a_name(name: Any) -> None:
    _refused(lambda: gb.Drivetrain(name), "a Drivetrain needs a name")


@pytest.mark.parametrize(
    ("part", "words"),
    [
        (gb.Inertia, "Inertia is a class: make one with its values"),
        (3, "3 is neither a block nor a Drivetrain"),
        (None, "None is neither"),
        (gb.Backlash(half_gap=1.0), "is neither a block nor a Drivetrain"),
    ],
)
def test_only_blocks_and_trains_are_parts(part: Any, words: str) -> None:
    _refused(lambda: gb.Drivetrain("r").add("x", part), words)
    _refused(lambda: _rig().set({"motor": part}), words)


def test_two_parts_of_one_name_are_refused() -> None:
    _refused(lambda: _rig().add("motor", _inertia()), "already has a part named 'motor'")


def test_a_mistaken_flange_is_named_with_the_near_one() -> None:
    rig = gb.Drivetrain("rig")
    mesh = rig.add("mesh", gb.GearMesh(teeth=(1, 2), external=True, module=1.0, pressure_angle=0.3, k=1.0))
    _refused(lambda: mesh.pinon, "'mesh' (GearMesh) has no flange 'pinon'", "did you mean 'pinion'?")


def test_connections_that_join_nothing_are_refused() -> None:
    rig = gb.Drivetrain("rig")
    a, s = rig.add("a", _inertia()), rig.add("s", gb.Shaft(k=1.0))
    for act, words in (
        (lambda: rig.connect(a.a, a.a), "flange a.a is connected to itself"),
        (lambda: rig.connect(a.a), "at least two"),
        (lambda: rig.connect(), "at least two"),
        (lambda: rig.connect(a, s), "name one of a.{a, b}"),  # type: ignore[arg-type]
        (lambda: rig.connect("a.a", "s.a"), "'a.a' is no flange of 'rig'"),  # type: ignore[arg-type]
        (lambda: gb.Drivetrain("z").connect(a.a, s.a), "is no flange of 'z'"),
        (lambda: rig.chain("a", "s"), "'a' is no part of 'rig'"),  # type: ignore[arg-type]
        (lambda: rig.chain(), "at least two parts"),
        (lambda: rig.chain([a, s]), "at least two parts, one by one"),  # type: ignore[arg-type]
        (lambda: rig.expose("x", "a.a"), "is no flange"),  # type: ignore[arg-type]
        (lambda: rig.expose("a b", a.a), "taken or no word"),
        (lambda: rig.coordinate("t", gb.sense("a.phi"), "rad"), "coordinate name 't' is taken"),
        (lambda: rig.coordinate("x", gb.time, "rad"), "only gb.sense(...)"),
        (lambda: rig.coordinate("x", "a.phi", "rad"), "neither a number nor an expression"),
        (lambda: rig["aa"], "has no part 'aa'"),
        (lambda: rig[3], "has no part '3'"),  # type: ignore[index]
    ):
        _refused(act, words)


def test_a_chain_does_not_pass_through_three_flanges() -> None:
    class Three(gb.Block):
        a, b, c = gb.Flange("a"), gb.Flange("b"), gb.Flange("c")

        def physics(self, s: Any) -> Any:
            yield gb.Tie(s.a.phi - s.b.phi)

    _refused(lambda: _chain(_inertia(), Three(), _inertia()), "'b1' has 3 flanges (a, b, c)", "use connect")


def test_a_shaft_on_one_node_and_all_open_ends_are_named_at_once() -> None:
    rig = gb.Drivetrain("rig")
    s, i = rig.add("s", gb.Shaft(k=1.0)), rig.add("i", _inertia())
    rig.connect(s.a, i.a)
    rig.connect(s.b, i.a)
    _refused(lambda: gb.build(rig), "Shaft 's' is connected to itself")
    rig = gb.Drivetrain("rig")
    rig.add("s", gb.Shaft(k=1.0))
    rig.add("g", gb.IdealGear(ratio=2.0))
    rig.add("t", gb.Torque(tau=1.0))
    _refused(lambda: gb.build(rig), "5 problems", "flange 'a' of Shaft 's' is open", "'flange' of Torque 't'")
    _refused(lambda: gb.build(gb.Drivetrain("nothing")), "'nothing' is empty")


def test_a_shaft_without_inertia_that_nothing_holds_is_named_by_its_end() -> None:
    rig = gb.Drivetrain("rig")
    load, brake = rig.add("load", gb.Torque(tau=1.0)), rig.add("other", gb.Torque(tau=1.0))
    rig.connect(load.flange, brake.flange)
    _refused(lambda: gb.build(rig), "the shaft at 'load.flange' has no inertia, and neither spring nor damper holds it")


def test_ties_that_contradict_are_named_with_their_loop() -> None:
    rig = gb.Drivetrain("rig")
    a, b = rig.add("a", _inertia()), rig.add("b", _inertia())
    one, two = rig.add("one", gb.IdealGear(ratio=2.0)), rig.add("two", gb.IdealGear(ratio=3.0))
    rig.connect(a.b, one.a, two.a)
    rig.connect(one.b, two.b, b.a)
    _refused(lambda: gb.build(rig), "'one'", "'two'", "contradict each other", "3 and 2 turns")


def test_start_values_that_contradict_are_refused_also_where_the_program_is_known_already() -> None:
    for ratio, w in ((1.0, 1.0), (2.0, 0.5)):
        gb.build(_chain(_inertia(w0=1.0), gb.IdealGear(ratio=ratio), _inertia(w0=w)))
        rig = _chain(_inertia(w0=1.0), gb.IdealGear(ratio=ratio), _inertia(w0=3.0))
        _refused(lambda rig=rig: gb.build(rig), "'b0': w0 = 1.0", "'b2': w0 = 3.0", "contradict")


@pytest.mark.parametrize(
    ("one", "other", "words"),
    [
        (gb.Parameter("P", 1.0), gb.Parameter("P", 2.0), "the name 'P' stands for"),
        (gb.Parameter("P", 1.0, "N m"), gb.Parameter("P", 1.0, "m"), "the name 'P' stands for"),
        (gb.Parameter("P", 1.0), gb.Input("P", 1.0), "the name 'P' stands for"),
        (gb.Input("P", 1.0), gb.Input("P", 2.0), "the name 'P' stands for"),
        (gb.Input("P", 1.0), gb.Input("P", 1.0, "N m"), "the name 'P' stands for"),
        (gb.Parameter("b1.J", 5.0), 1.0, "has the name of the parameter 'b1.J'"),
        (gb.Input("b1.J", 5.0), 1.0, "has the name of the parameter 'b1.J'"),
        (gb.Parameter("b1.w", 5.0), 1.0, "'b1.w' names an input or Parameter and an output"),
        (gb.Input("b1.w", 5.0), 1.0, "'b1.w' names an input or Parameter and an output"),
    ],
)
def test_one_name_means_one_thing(one: Any, other: Any, words: str) -> None:
    _refused(lambda: gb.build(_chain(gb.Torque(tau=one), _inertia(), gb.Torque(tau=other))), words)


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("b1.ww", "did you mean 'b1.w'"),
        ("moter.w", "sense('moter.w')"),
        ("b1", "no block shows that output"),
        ("b1.alpha", "cannot be fed back"),
        ("b0.torque", "algebraic loop: b0.torque -> b0.torque"),
    ],
)
def test_a_sense_of_nothing_or_of_itself_is_refused(path: str, words: str) -> None:
    _refused(lambda: gb.build(_chain(gb.Torque(tau=0.5 * gb.sense(path)), _inertia())), words)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"motor.j": 1}, ["'motor.j' does not exist", "did you mean 'motor.J'"]),
        ({"moter.J": 1}, ["'moter.J' does not exist"]),
        ({"J": 1}, ["'J' is not unique", "motor.J", "wheel.J"]),
        ({"motor.J": NAN}, ["Inertia 'motor': J = nan kg m2 must be a finite number"]),
        ({"motor.J": None}, ["a value must be given"]),
        ({"motor.J.x": 3}, ["does not exist"]),
        ({3: 4}, ["path 3 must be text"]),
        ("motor.J", ["must be a dict"]),
        ({"motor": gb.Fixed()}, ["the new 'motor' has no flange 'a', which is connected"]),
        ({"motor": gb.Drivetrain("z")}, ["the new 'motor' has no flange"]),
        ({"motor.J": -1, "shaft.k": -1, "wheel.q": 1}, ["3 problems", "wheel.q", "J = -1", "k = -1"]),
    ],
)
def test_set_names_every_mistake_and_changes_nothing(values: Any, words: list[str]) -> None:
    rig = _rig()
    before = rig.describe()
    _refused(lambda: rig.set(values), *words)
    assert rig.describe() == before


def test_set_takes_values_that_only_fit_together() -> None:
    rig = gb.Drivetrain("rig")
    rig.add("mesh", gb.GearMesh(teeth=(10, 20), external=True, r_base=(0.1, 0.2), k=1.0))
    changed = rig.set({"mesh.teeth": (10, 30), "mesh.r_base": (0.1, 0.3)})
    assert "(10, 30)" in changed.describe()
    _refused(lambda: rig.set({"mesh.teeth": (10, 30)}), "r_base = (0.1, 0.2)", "teeth = (10, 30)")


@pytest.mark.parametrize("method", ["without", "only"])
def test_patterns_that_match_no_effect_are_named(method: str) -> None:
    take = getattr(_rig(), method)
    _refused(
        lambda: take("*.frction", "shft.compliance"), "2 problems", "'*.frction'", "did you mean 'shaft.compliance'"
    )
    _refused(lambda: take(["shaft.damping"]), "one by one as text")
    _refused(lambda: take(3), "one by one as text")


# -- files ------------------------------------------------------------------------------------------------------------


def test_a_train_survives_its_file(tmp_path: Path) -> None:
    rig = _rig()
    rig.connect(rig.add("gear", gb.IdealGear(ratio=Fraction(1, 3))).a, Handle(rig, "wheel", rig["wheel"]).b)
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
    _refused(lambda: gb.Drivetrain.from_json(tmp_path / "none.json"), "none.json", "cannot be read")


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
