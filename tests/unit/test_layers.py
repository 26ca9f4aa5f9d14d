"""Imports lead downward only, between rooms and between the files of a room; and no file is long."""

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

ROOMS: tuple[tuple[str, ...], ...] = (
    ("gearblocks.errors", "gearblocks.files", "gearblocks.pages"),
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


def _imports(module: str, path: Path) -> Iterator[tuple[int, str]]:
    """Line and name of every module of ours that a file imports, within functions and for types too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module}, line {node.lineno}: write the whole name"
            base = node.module or ""
            inner = [f"{base}.{alias.name}" for alias in node.names]
            names = [name if name in MODULES else base for name in inner]
        else:
            continue
        yield from ((node.lineno, name) for name in names if name in MODULES)


@pytest.mark.parametrize("module", MODULES)
def test_a_file_imports_only_from_its_own_room_and_those_above_it(module: str) -> None:
    own = _room(module)
    upward = [f"line {line}: {name}" for line, name in _imports(module, MODULES[module]) if _room(name) > own]
    assert not upward, f"{module} looks down"


def test_no_file_reaches_itself_through_its_imports() -> None:
    # the name of a room stands for what its __init__.py imports, and only then
    graph = {module: {name for _, name in _imports(module, path) if name != module} for module, path in MODULES.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


@pytest.mark.parametrize("module", MODULES)
def test_a_module_and_its_functions_can_be_read_in_one_go(module: str) -> None:
    text = MODULES[module].read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 400, "split it by concept"
    functions = [x for x in ast.walk(ast.parse(text)) if isinstance(x, ast.FunctionDef | ast.AsyncFunctionDef)]
    assert not [f.name for f in functions if (f.end_lineno or 0) - f.lineno >= 60]


@pytest.mark.parametrize("path", TEMPLATES, ids=lambda path: path.name)
def test_a_template_can_be_read_in_one_go(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 250
