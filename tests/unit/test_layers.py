"""Imports lead downward only, between rooms and between the files of a room; and no file is long."""

import ast
import functools
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

ROOMS: tuple[tuple[str, ...], ...] = (
    ("gearblocks.errors", "gearblocks.files", "gearblocks.pages", "gearblocks.plurals", "gearblocks.progress"),
    ("gearblocks.language",),
    ("gearblocks.geometry",),
    ("gearblocks.laws",),
    ("gearblocks.blocks",),
    ("gearblocks.train",),
    ("gearblocks.drawing",),
    ("gearblocks.assembly",),
    ("gearblocks.equations",),
    ("gearblocks.codegen",),
    ("gearblocks.solver",),
    ("gearblocks.model",),
    ("gearblocks.simulation",),
    ("gearblocks.drivetrain", "gearblocks.running"),
    ("gearblocks.analysis",),
    ("gearblocks",),
    ("gearblocks.hard",),
    ("fmu_export",),
    ("gearblocks.cli", "gearblocks.__main__"),
)
"""From the ground up. A file may import from its own room and from those above it in this list."""


def _module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {
    _module_of(path): path for name in ("gearblocks", "fmu_export") for path in sorted((ROOT / name).rglob("*.py"))
}


TEMPLATES = [path for name in ("gearblocks", "fmu_export") for path in sorted((ROOT / name).rglob("*.jinja"))]


def _room(module: str) -> int:
    """The number of the room that a module lies in, or is."""
    for number, names in enumerate(ROOMS):
        if any(module == name or (name != "gearblocks" and module.startswith(f"{name}.")) for name in names):
            return number
    raise LookupError(f"'{module}' lies in no room: give it one, or a room its place in {Path(__file__).name}")


def _statements(tree: ast.AST) -> Iterator[ast.stmt]:
    """All statements below a node; expressions hold none."""
    for name in ("body", "handlers", "orelse", "finalbody", "cases"):
        for below in getattr(tree, name, ()):
            if isinstance(below, ast.stmt):
                yield below
            yield from _statements(below)


@functools.cache
def _of_file(module: str) -> tuple[tuple[tuple[int, str], ...], tuple[tuple[str, int], ...], int]:
    """What is asked of a file, read once: line and name of every module of ours that it imports, within functions and for
    types too; names and lengths of its functions; how many lines it has."""
    text = MODULES[module].read_text(encoding="utf-8")
    imports: list[tuple[int, str]] = []
    functions: list[tuple[str, int]] = []
    for node in _statements(ast.parse(text)):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module}, line {node.lineno}: write the whole name"
            base = node.module or ""
            inner = [f"{base}.{alias.name}" for alias in node.names]
            names = [name if name in MODULES else base for name in inner]
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            functions.append((node.name, (node.end_lineno or 0) - node.lineno + 1))
        imports += [(node.lineno, name) for name in names if name in MODULES]
    return tuple(imports), tuple(functions), len(text.splitlines())


def _files_of(number: int) -> list[str]:
    return [module for module in MODULES if _room(module) == number]


def test_every_file_lies_in_a_room_and_no_room_is_empty() -> None:
    assert {_room(module) for module in MODULES} == set(range(len(ROOMS)))


@pytest.mark.parametrize("number", range(len(ROOMS)), ids=[names[0] for names in ROOMS])
def test_a_file_imports_only_from_its_own_room_and_those_above_it(number: int) -> None:
    upward = [
        f"{module}, line {line}: {name}"
        for module in _files_of(number)
        for line, name in _of_file(module)[0]
        if _room(name) > number
    ]
    assert not upward, "they look down"


def test_no_file_reaches_itself_through_its_imports() -> None:
    # the name of a room stands for what its __init__.py imports, and only then
    graph = {module: {name for _, name in _of_file(module)[0] if name != module} for module in MODULES}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


@pytest.mark.parametrize("number", range(len(ROOMS)), ids=[names[0] for names in ROOMS])
def test_modules_and_their_functions_can_be_read_in_one_go(number: int) -> None:
    files = {module: _of_file(module) for module in _files_of(number)}
    assert [module for module, (_, _, lines) in files.items() if lines > 400] == [], "split them by concept"
    long = [f"{module}: {name}" for module, (_, found, _) in files.items() for name, lines in found if lines > 60]
    assert long == []


@pytest.mark.parametrize("path", TEMPLATES, ids=lambda path: path.name)
def test_a_template_can_be_read_in_one_go(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 250
