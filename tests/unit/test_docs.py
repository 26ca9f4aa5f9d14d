"""The documents name what is there: rooms, files, functions, pictures."""

import ast
import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

import gearblocks as gb
from gearblocks import blocks

ROOT = Path(__file__).parents[2]
DOCS, PACKAGE = ROOT / "docs", ROOT / "gearblocks"
ARCHITECTURE = (DOCS / "architecture.md").read_text(encoding="utf-8")
NAMED = sorted(set(re.findall(r"`((?:[\w.]+/)*\w[\w.]*\.(?:py|c|h|jinja|md))(?::([\w.]+))?`", ARCHITECTURE)))
MARKDOWN = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]


def _loaded(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"docs_{path.stem}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def _found(path: str) -> Path | None:
    """A file that a text names: of the package, or of the repository."""
    return next((x for x in (PACKAGE / path, ROOT / path) if x.is_file()), None)


def _names(path: Path) -> set[str]:
    """Functions, classes and methods of a Python file."""
    found = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
            inner = node.body if isinstance(node, ast.ClassDef) else []
            found |= {f"{node.name}.{x.name}" for x in inner if isinstance(x, ast.FunctionDef)}
    return found


def _is_there(path: str, name: str) -> bool:
    file = _found(path)
    if file is None or not name:
        return file is not None
    if file.suffix == ".py":
        return name in _names(file)
    return re.search(rf"\b{name}\b", file.read_text(encoding="utf-8")) is not None


@pytest.mark.parametrize(("path", "name"), NAMED)
def test_what_the_architecture_names_is_there(path: str, name: str) -> None:
    assert _is_there(path, name)


def test_the_generated_c_of_the_architecture_is_generated() -> None:
    rig = gb.Drivetrain("pair")
    pinion = rig.add("pinion", gb.Inertia(J=1e-3))
    mesh = rig.add(
        "mesh", gb.GearMesh(teeth=(23, 41), module=3e-3, pressure_angle=0.35, external=True, k=1e8, damping_ratio=0.05)
    )
    rig.chain(pinion, mesh, rig.add("wheel", gb.Inertia(J=2e-3)))
    program = gb.build(rig).program
    excerpt = ARCHITECTURE.split("```c\n")[1].split("```")[0]
    lines = re.findall(r"^ *(.+?)(?:\.\.\.)?;? +/\* (\w+) \*/$", excerpt, re.M)
    assert len(lines) == excerpt.count(";")
    for text, function in lines:
        body = program.source.split(f"{function}(")[1].split("\n}")[0]
        assert text in body
    (index,) = (i for i, p in enumerate(program.parameters) if p.path == "mesh.k")
    assert f"`par[{index}]`" in ARCHITECTURE


def test_the_rooms_of_the_architecture_are_those_that_imports_are_held_to() -> None:
    drawing, layers = _loaded(DOCS / "draw_rooms.py"), _loaded(Path(__file__).with_name("test_layers.py"))
    there = [tuple(name for name in names if name in layers.MODULES) for names in layers.ROOMS]
    assert [room.modules for room in drawing.rooms()] == there


def test_the_picture_of_the_rooms_is_that_of_the_sources() -> None:
    drawing = _loaded(DOCS / "draw_rooms.py")
    text = drawing.PICTURE.read_text(encoding="utf-8")
    assert text == drawing.picture(), "the picture is stale: python docs/draw_rooms.py"


def test_the_schemes_in_the_documents_are_those_of_their_trains() -> None:
    drawing = _loaded(DOCS / "draw_trains.py")
    for name, text in drawing.pictures().items():
        there = (drawing.PICTURES / name).read_text(encoding="utf-8")
        assert there == text, f"{name} is stale: python docs/draw_trains.py"


def test_every_block_of_the_catalogue_is_among_the_symbols() -> None:
    drawing = _loaded(DOCS / "draw_trains.py")
    shown = {type(block).__name__ for name, make in drawing.TRAINS.items() if name.startswith("symbols_")
             for _, _, _, block in make()._walk()}  # fmt: skip
    assert shown == {name for name in blocks.__all__ if issubclass(getattr(blocks, name), gb.Block)}


@pytest.mark.parametrize("path", MARKDOWN, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_links_between_documents_lead_somewhere(path: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", path.read_text(encoding="utf-8")):
        if "://" not in target:
            assert (path.parent / target).exists(), target


def test_decisions_have_a_number_each_and_bear_it_in_their_heading() -> None:
    paths = sorted((DOCS / "decisions").glob("*.md"))
    numbers = [int(path.name[:4]) for path in paths]
    assert len(set(numbers)) == len(numbers)
    for number, path in zip(numbers, paths, strict=True):
        assert path.read_text(encoding="utf-8").startswith(f"# {number}. ")
