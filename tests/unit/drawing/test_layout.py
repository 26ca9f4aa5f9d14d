"""Drawings: no two boxes overlap, no line crosses a box, every block is there; and what each of them shows."""

from collections.abc import Iterable, Iterator
from itertools import combinations, pairwise, product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

import gearblocks as gb
from gearblocks import blocks
from gearblocks.cli import scripts
from gearblocks.drawing.drawing import drawing_of
from gearblocks.drawing.layout import WIDTH, Box, Layout, Wire, layout
from gearblocks.drawing.planet_sets import CARRIER, Gearing
from gearblocks.drawing.scheme import scheme_of
from gearblocks.drawing.sets import stick_scheme
from gearblocks.drawing.shapes import Shape, Stroke, Words
from gearblocks.train.graph import Tree, flatten
from tests.random.description import build
from tests.random.families import FAMILIES, draw

MODELS = [f"{name}:{maker.name}" for name, path in scripts.shipped().items() for maker in scripts.makers(path)]
RANDOM = [(family, seed) for seed in range(5) for family in FAMILIES]
PLAIN = {gb.Governor, gb.ThermalConductance, gb.ThermalMass}
PLAIN_WHERE_HOUSED = {gb.BeltDrive, gb.TorqueConverter, gb.Engine, gb.EddyCurrentBrake, gb.SpeedLoad}
SLACK = 1e-6  # rounding of sums of widths


def _overlap(a: Box, b: Box) -> bool:
    return (
        a.x < b.x + b.width - SLACK and b.x < a.x + a.width - SLACK
        and a.y < b.y + b.height - SLACK and b.y < a.y + a.height - SLACK
    )  # fmt: skip


def _stretches(found: Layout) -> list[Box]:
    """Every straight piece of a line as a box without width."""
    return [piece for wire in found.wires for piece in _stretches_of(wire)]


def _stretches_of(wire: Wire) -> list[Box]:
    pieces = [*pairwise(wire.points)]
    assert all(a[0] == b[0] or a[1] == b[1] for a, b in pieces)
    return [Box(min(a[0], b[0]), min(a[1], b[1]), abs(a[0] - b[0]), abs(a[1] - b[1]), -1) for a, b in pieces]


def _inside(a: Box, found: Layout) -> bool:
    return a.x >= 0 and a.y >= 0 and a.x + a.width <= found.width and a.y + a.height <= found.height


def _check_geometry(found: Layout) -> None:
    assert [(a, b) for a, b in combinations(found.boxes, 2) if _overlap(a, b)] == []
    stretches = _stretches(found)
    assert [(a, b) for a in stretches for b in found.boxes if _overlap(a, b)] == []
    assert [a for a in (*found.boxes, *stretches) if not _inside(a, found)] == []
    _check_ends(found)
    _check_words(found)


def _check_words(found: Layout) -> None:
    """No line of a stick scheme strikes through the numbers of its planets."""
    for figure in found.figures:
        _check_numbers(figure.shapes)


def _check_numbers(shapes: Iterable[Shape]) -> int:
    """How many numbers of planets there are; no line touches one."""
    numbers = [s for s in shapes if isinstance(s, Words) and s.text.endswith("×")]
    for words in numbers:
        box = Box(words.x - 3.0 * len(words.text), words.y - 6.0, 6.0 * len(words.text), 6.0, -1)
        strokes = (s for s in shapes if isinstance(s, Stroke))
        through = [(a, b) for s in strokes for a, b in pairwise(s.points) if _touches(box, _stretch(a, b))]
        assert through == [], f"{words.text} is struck through"
    return len(numbers)


def _stretch(a: tuple[float, float], b: tuple[float, float]) -> Box:
    return Box(min(a[0], b[0]), min(a[1], b[1]), abs(a[0] - b[0]), abs(a[1] - b[1]), -1)


def _check_ends(found: Layout) -> None:
    """A line ends at a symbol, which goes on there, or at another line of its shaft."""
    drawn = [(box, _points(found, box.element)) for box in found.boxes]
    for wire in found.wires:
        others = [s for w in found.wires if w.shaft == wire.shaft and w is not wire for s in _stretches_of(w)]
        for x, y in (wire.points[0], wire.points[-1]):
            at = Box(x, y, 0.0, 0.0, -1)
            at_line = any(_touches(at, other) for other in others)
            at_symbol = any(_touches(at, box) and any(abs(x - a) + abs(y - b) < SLACK for a, b in points)
                            for box, points in drawn)  # fmt: skip
            assert at_line or at_symbol or wire.shaft == -1, f"the end ({x}, {y}) hangs in the air"


def _points(found: Layout, element: int) -> set[tuple[float, float]]:
    """Corners of all that is drawn of an element."""
    shapes = (s for figure in found.figures if figure.number == element for s in figure.shapes)
    return {p for s in shapes if isinstance(s, Stroke) for p in s.points}


def _touches(a: Box, b: Box) -> bool:
    return (
        a.x <= b.x + b.width + SLACK and b.x <= a.x + a.width + SLACK
        and a.y <= b.y + b.height + SLACK and b.y <= a.y + a.height + SLACK
    )  # fmt: skip


def _check(rig: gb.Drivetrain, **options: Any) -> None:
    drawing = rig.draw(**options)
    found = drawing.layout
    _check_geometry(found)
    assert found.width <= WIDTH
    assert {box.element for box in found.boxes} == set(range(len(drawing.scheme.elements)))
    ElementTree.fromstring(drawing.text)
    for path in (c.path for c in flatten(rig.tree(), whole=True).components):
        assert f"{path}: " in drawing.text


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.few(4)
def test_drawings_of_shipped_models_fit_a_page_and_in_them_no_box_overlaps_a_box_or_a_line(model: str) -> None:
    _check(scripts.make(model))


SETS = {
    "one planet": Gearing(("sun",), ("ring",), (4,), ((0, "sun"), (0, "ring"))),
    "two suns": Gearing(("one", "two"), (), (12,), ((0, "one"), (0, "two"))),
    "double planets": Gearing(("sun",), ("ring",), (3, 3), ((0, "sun"), (0, 1), (1, "ring"))),
}


@pytest.mark.parametrize("which", SETS)
def test_numbers_of_planets_stand_where_no_line_is_whatever_side_the_ports_leave_to(which: str) -> None:
    gearing = SETS[which]
    ports = (*gearing.suns, *gearing.rings, CARRIER)
    for sides, held in product(product((-1, 1), repeat=len(ports)), (None, *ports)):
        found = stick_scheme(gearing, ports, sides, () if held is None else (held,))
        assert _check_numbers(found.shapes) == len(gearing.counts)


@pytest.mark.parametrize(("family", "seed"), RANDOM)
@pytest.mark.few(3)
def test_drawings_of_random_trains_fit_a_page_and_in_them_no_box_overlaps_a_box_or_a_line(
    family: str, seed: int
) -> None:
    _check(build(draw(family, seed), gb))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.few(3)
def test_values_printed_beside_the_symbols_overlap_nothing(model: str) -> None:
    _check(scripts.make(model), values=True)


def _pair(**mesh: Any) -> gb.Drivetrain:
    rig = gb.Drivetrain("a pair")
    parts = [
        rig.add("drive", gb.Torque(tau=1.0)), rig.add("pinion", gb.Inertia(J=1.0)),
        rig.add("gear", gb.IdealGear(teeth=(20, 40), external=True, **mesh)), rig.add("wheel", gb.Inertia(J=1.0)),
    ]  # fmt: skip
    rig.chain(*parts)
    return rig


def test_the_shafts_of_a_gear_pair_are_two_parallel_lines() -> None:
    scheme = scheme_of(flatten(_pair().tree(), whole=True))
    found = layout(scheme)
    assert scheme.shafts == ("pinion", "wheel")
    heights = {wire.shaft: {y for _, y in wire.points} for wire in found.wires}
    assert len(heights[0]) == len(heights[1]) == 1 and heights[0] != heights[1]


def test_bodies_and_springs_in_a_row_lie_on_one_line() -> None:
    found = scripts.make("spline_coupling").draw().layout
    assert len({y for wire in found.wires for _, y in wire.points}) == 1


def test_a_long_chain_is_folded() -> None:
    found = scripts.make("stiff_chain").draw().layout
    assert found.width <= WIDTH and len({round(box.y + box.height / 2, -2) for box in found.boxes}) > 5


def test_four_planets_that_mesh_alike_are_one_set() -> None:
    scheme = scripts.make("planetary_backlash").draw().scheme
    sets = [e for e in scheme.elements if e.gearing is not None]
    assert len(sets) == 1 and len(sets[0].blocks) == 12
    assert sets[0].gearing is not None and sets[0].gearing.counts == (4,)
    assert [name for name, _ in sets[0].ports] == ["sun", "carrier", "ring"]


def test_a_ravigneaux_set_is_one_symbol_with_two_suns_two_planets_and_a_ring() -> None:
    (gearing,) = (e.gearing for e in scripts.make("planetary_sets").draw().scheme.elements if e.gearing is not None)
    assert gearing.suns == ("small", "large") and gearing.rings == ("ring",) and gearing.counts == (1, 1)


def test_elements_side_by_side_are_one_symbol() -> None:
    rig = gb.Drivetrain("spring beside damper")
    a, b = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=1.0))
    rig.chain(a, rig.add("spring", gb.Shaft(k=1.0)), b)
    rig.chain(a, rig.add("damper", gb.Damper(c=1.0)), b)
    assert len(rig.draw().layout.boxes) == 3


def test_a_fixed_end_is_drawn_where_something_stands_on_it() -> None:
    rig = gb.Drivetrain("pendulum")
    rig.chain(rig.add("wall", gb.Fixed()), rig.add("spring", gb.Shaft(k=1.0)), rig.add("disc", gb.Inertia(J=1.0)))
    drawing = rig.draw()
    assert [e.grounded for e in drawing.scheme.elements] == [("a",), ()]
    assert "wall: Fixed" in drawing.text


BLOCKS = [
    kind for name in blocks.__all__ if isinstance(kind := getattr(blocks, name), type) and issubclass(kind, gb.Block)
]


@pytest.mark.parametrize("housed", [False, True])
@pytest.mark.parametrize("kind", BLOCKS)
def test_every_block_of_the_catalogue_has_a_symbol(kind: type[gb.Block], housed: bool) -> None:
    block = object.__new__(kind)  # a symbol hangs on the class; values are not needed
    block.__dict__.update(dict.fromkeys(kind.fields))
    block.__dict__.update({"planets": 3, "ratio": 2.0})
    sliding = any(f.slider for f in kind.flanges.values())
    parts: list[tuple[str, Any]] = [("part", block)]
    links = []
    for flange, spec in kind.flanges.items():
        if spec.ground and not spec.spare and not housed:
            continue
        body: gb.Block = gb.Mass(m=1.0) if spec.slider or (sliding and spec.slider is None) else gb.Inertia(J=1.0)
        parts.append((f"body_{flange}", body))
        links.append((("part", flange), (f"body_{flange}", "a")))
    drawing = drawing_of(Tree("one block", tuple(parts), tuple(links)))
    _check_geometry(drawing.layout)
    plain = PLAIN | (PLAIN_WHERE_HOUSED if housed else set())
    assert (f">{kind.__name__}</text>" in drawing.text) == (kind in plain)


@pytest.mark.parametrize(
    "moving", [(), ("frame",), ("housing",), ("housing", "frame")], ids=lambda x: "-".join(x) or "none"
)
def test_the_frame_of_a_rack_is_drawn_fixed_or_where_it_moves(moving: tuple[str, ...]) -> None:
    """It stood nowhere, and a rack in a frame that moves was a box with its name."""
    rig = gb.Drivetrain("steering")
    pinion, rack, rod = (
        rig.add(n, b)
        for n, b in (("pinion", gb.Inertia(J=1.0)), ("rack", gb.Rack(radius=0.01)), ("rod", gb.Mass(m=1.0)))
    )
    rig.connect(pinion.a, rack.flange)
    rig.connect(rack.slider, rod.a)
    for name in moving:
        rig.connect(
            getattr(rack, name), rig.add(f"the_{name}", gb.Mass(m=3.0) if name == "frame" else gb.Inertia(J=3.0)).a
        )
    drawing = rig.draw()
    _check_geometry(drawing.layout)
    assert ">Rack</text>" not in drawing.text
    (figure,) = (f for f in drawing.layout.figures if f.element.name == "rack")
    box = next(b for b in drawing.layout.boxes if b.element == figure.number)
    strokes = [s for s in figure.shapes if isinstance(s, Stroke)]
    assert all(box.x - SLACK <= x <= box.x + box.width + SLACK and box.y - SLACK <= y <= box.y + box.height + SLACK
               for s in strokes for x, y in s.points)  # fmt: skip
    slanted = [
        s
        for s in strokes
        if len(s.points) == 2 and s.points[0][0] != s.points[1][0] and s.points[0][1] != s.points[1][1]
    ]
    assert len(slanted) == (0 if moving else 5)  # the ground that a frame stands on where it does not move
    ports = [flange for flange, _ in figure.element.ports]
    assert ports == ["flange", "slider", *moving]


def test_a_wheel_that_a_fixed_holds_is_grounded_within_the_set() -> None:
    rig = gb.Drivetrain("reduction")
    sun, carrier = rig.add("sun", gb.Inertia(J=1.0)), rig.add("carrier", gb.Inertia(J=1.0))
    gear, wall = rig.add("gear", gb.IdealPlanetary(ratio=2)), rig.add("wall", gb.Fixed())
    rig.connect(sun.a, gear.sun)
    rig.connect(gear.carrier, carrier.a)
    rig.connect(gear.ring, wall.flange)
    drawing = rig.draw()
    assert len(drawing.layout.boxes) == 3
    assert [e.grounded for e in drawing.scheme.elements if e.gearing is not None] == [("ring",)]


def test_parts_that_are_not_connected_are_drawn_beside_each_other() -> None:
    rig = gb.Drivetrain("two trains")
    rig.connect(rig.add("a", gb.Inertia(J=1.0)).a, rig.add("b", gb.Inertia(J=1.0)).a)
    rig.connect(rig.add("drive", gb.Torque(tau=1.0)).flange, rig.add("c", gb.Inertia(J=1.0)).a)
    found = rig.draw()
    _check_geometry(found.layout)
    assert found.layout.figures[0].title.startswith("drive:")


def test_a_block_of_ones_own_is_a_box_with_the_name_of_its_class() -> None:
    class Gizmo(gb.Block):
        a, b, c = gb.Flange("one"), gb.Flange("two"), gb.Flange("three")

        def physics(self, s: Any) -> Iterator[gb.Tie]:
            yield gb.Tie(s.a.phi - s.b.phi + s.c.phi)

    rig = gb.Drivetrain("with a gizmo")
    gizmo = rig.add("gizmo", Gizmo())
    for name in "abc":
        rig.connect(getattr(gizmo, name), rig.add(f"body_{name}", gb.Inertia(J=1.0)).a)
    text = str(rig.draw())
    assert ">Gizmo</text>" in text and ">a</text>" in text and ">c</text>" in text


def test_blocks_of_nested_trains_are_drawn_with_their_paths() -> None:
    inner = _pair()
    outer = gb.Drivetrain("outer")
    outer.add("stage", inner)
    assert "stage.gear: IdealGear" in str(outer.draw())


def test_names_are_escaped() -> None:
    rig = gb.Drivetrain("a < b\x00 & c")
    rig.add("body", gb.Inertia(J=1.0))
    assert ElementTree.fromstring(rig._repr_svg_() or "")[0].text == "a < b & c"


def test_open_ends_are_drawn_and_an_empty_train_is_not() -> None:
    rig = gb.Drivetrain("begun")
    assert rig._repr_svg_() is None
    rig.add("spring", gb.Shaft(k=1.0))
    assert len(rig.draw().layout.boxes) == 1


def test_a_drawing_is_saved_as_svg_alone(tmp_path: Path) -> None:
    drawing = _pair().draw()
    drawing.save(tmp_path / "pair.svg")
    assert (tmp_path / "pair.svg").read_text(encoding="utf-8") == str(drawing) == drawing._repr_svg_()
    with pytest.raises(gb.ParameterError, match=r"must end in \.svg"):
        drawing.save(tmp_path / "pair.png")
    with pytest.raises(gb.ParameterError, match="is no name of a file"):
        _pair().draw(5)  # type: ignore[arg-type]
    assert _pair().draw(tmp_path / "again.svg").text == (tmp_path / "again.svg").read_text(encoding="utf-8")


_MESH = {
    "teeth": (23, 41),
    "module": "3 mm",
    "pressure_angle": "20 deg",
    "external": True,
    "k": 2e8,
    "damping_ratio": 0.05,
}


@pytest.mark.parametrize(
    ("block", "told"),
    [
        (gb.GearMesh(**_MESH, backlash=gb.Backlash(half_gap="30 um")), ["teeth = 23:41", "k = 2e8 N/m", "half_gap = 30 um"]),
        (gb.GearMesh(**_MESH), ["teeth = 23:41", "k = 2e8 N/m", "damping_ratio = 0.05"]),
        (
            gb.SplineCoupling(teeth=9, radius=0.1, k=2e6, c=0.2, backlash=gb.Backlash(half_gap=1e-5)),
            ["k = 2e6 N/m", "half_gap = 1e-5 m"],
        ),
        (gb.Governor(target="1500 rpm", gain=0.02, integral_gain=0.0212345), ["integral_gain =", "0.02123 1/rad"]),
        (gb.LossyGear(ratio=3, efficiency=(0.95, 0.9), bearing=(1, 1)), ["efficiency = 0.95, 0.9", "bearing = 1, 1 N m"]),
        (gb.Governor(target=gb.sense("load.w"), gain=0.02), ["target = load.w"]),
        (gb.SpeedLoad(coeffs=(0.0, 0.0, 0.01)), ["coeffs =", "0.01 N m s2/rad2"]),
        (gb.Brake(capacity=gb.Table([0, 1], [0, 5])), ["capacity = a table"]),
        (
            gb.NonCircularGear(
                law=gb.RatioLaw.ellipse(0.3), external=True, k=1e4, c=1.0, backlash=gb.Backlash(half_gap=1e-3)
            ),
            ["half_gap = 0.001 rad"],
        ),
    ],
)  # fmt: skip
def test_the_values_beside_a_symbol_are_whole_and_those_that_matter(block: gb.Block, told: list[str]) -> None:
    rig = gb.Drivetrain("values")
    part, load = rig.add("part", block), rig.add("load", gb.Inertia(J=1.0))
    rig.connect(getattr(part, next(iter(type(block).flanges))), load.a)
    text = str(rig.draw(values=True))
    assert [x for x in told if f">{x}</text>" not in text] == []
    assert "…</text>" not in text
