"""Files import downward only."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

# From the ground up. A module may import from its own floor and from those above it in this list. A name stands for the
# module and everything in it.
FLOORS: tuple[tuple[str, ...], ...] = (
    ("gearblocks.errors", "gearblocks.rational", "gearblocks.pattern", "gearblocks.sparsemaps"),
    ("gearblocks.tooth_geometry", "gearblocks.dead_zone", "gearblocks.engagement", "gearblocks.impact"),
    ("gearblocks.units", "gearblocks.files", "gearblocks.program", "gearblocks.cache", "gearblocks.compiler"),
    ("gearblocks.expression", "gearblocks.signals", "gearblocks.maps"),
    ("gearblocks.ratio_curves", "gearblocks.ratio_law", "gearblocks.ratio_making", "gearblocks.pitch"),
    ("gearblocks.declare",),
    (
        "gearblocks.symbols",
        "gearblocks.branches",
        "gearblocks.contributions",
        "gearblocks.sticks",
        "gearblocks.printer",
    ),
    ("gearblocks.letters", "gearblocks.rubs", "gearblocks.written"),
    ("gearblocks.gaps", "gearblocks.effects"),
    ("gearblocks.blocks",),
    ("gearblocks.nesting", "gearblocks.sliding"),
    ("gearblocks.graph",),
    ("gearblocks.affine",),
    ("gearblocks.drives", "gearblocks.laws", "gearblocks.ties", "gearblocks.coordinates", "gearblocks.kinematics"),
    ("gearblocks.floating",),
    ("gearblocks.grouping", "gearblocks.assemble", "gearblocks.carrying", "gearblocks.equations"),
    ("gearblocks.rosenbrock", "gearblocks.hoist", "gearblocks.layout", "gearblocks.turns"),
    ("gearblocks.methods",),
    (
        "gearblocks.batchcode",
        "gearblocks.locks",
        "gearblocks.massless",
        "gearblocks.motions",
        "gearblocks.senses",
        "gearblocks.generator",
    ),
    (
        "gearblocks.slopes",
        "gearblocks.rownumbers",
        "gearblocks.driveslopes",
        "gearblocks.varying",
        "gearblocks.unknowns",
        "gearblocks.jacobian",
        "gearblocks.means",
        "gearblocks.reactions",
        "gearblocks.views",
        "gearblocks.quantities",
        "gearblocks.codegen",
    ),
    ("gearblocks.stepmatrix", "gearblocks.lockview", "gearblocks.core", "gearblocks.library"),
    ("gearblocks.given_starts",),
    ("gearblocks.building",),
    ("gearblocks.holding",),
    ("gearblocks.probing", "gearblocks.standing", "gearblocks.statics"),
    ("gearblocks.records", "gearblocks.storage", "gearblocks.plotting", "gearblocks.trajectory"),
    ("gearblocks.arguments", "gearblocks.runs"),
    ("gearblocks.scene", "gearblocks.analysis", "gearblocks.cost"),
    ("gearblocks.json_form", "gearblocks.rigid", "gearblocks.handles", "gearblocks.drivetrain"),
    ("gearblocks.reduction",),
    ("gearblocks.linear", "gearblocks.vibration", "gearblocks.orders", "gearblocks.linear_pictures"),
    ("gearblocks",),
    ("gearblocks.hard",),
    ("fmu_export",),
    ("gearblocks.scripts", "gearblocks.report", "gearblocks.demo", "gearblocks.cli", "gearblocks.__main__"),
)


def _module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {
    _module_of(path): path for name in ("gearblocks", "fmu_export") for path in sorted((ROOT / name).rglob("*.py"))
}


def _floor(module: str) -> int:
    """The floor of a module: that of the longest name in the table that it is, or lies in."""
    while True:
        for number, names in enumerate(FLOORS):
            if module in names:
                return number
        module, _, last = module.rpartition(".")
        if not module or module == "gearblocks":
            raise LookupError(f"'{last}' has no floor yet: give it one in {Path(__file__).name}")


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
def test_a_file_imports_only_from_lower_floors(module: str) -> None:
    own = _floor(module)
    upward = [f"line {line}: {name}" for line, name in _imports(module, MODULES[module]) if _floor(name) > own]
    assert not upward, f"{module} looks up"
