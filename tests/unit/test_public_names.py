"""The public names: what dir shows, and that no inner module hides one of them."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import gearblocks as gb

FUNCTIONS = (
    "build", "campbell", "classify", "design_ratio", "effect", "exact", "frequency_response", "linearize",
    "modes", "option", "param", "poincare", "rpm", "sense", "signal", "simulate", "stroboscopic",
)  # fmt: skip

IMPORT_ALL = """
import importlib, pkgutil, sys, types
import gearblocks as gb
public = {name: getattr(gb, name) for name in gb.__all__}
shown = dir(gb)
for found in pkgutil.walk_packages(gb.__path__, "gearblocks."):
    if not found.name.endswith("__main__"):
        importlib.import_module(found.name)
print("hidden:", [name for name, value in public.items() if getattr(gb, name) is not value])
print("modules:", [name for name in gb.__all__ if isinstance(getattr(gb, name), types.ModuleType)])
print("not callable:", [name for name in sys.argv[1:] if not callable(getattr(gb, name))])
print("changed:", sorted({*shown} ^ {*dir(gb)}))
"""


def test_dir_shows_the_public_names_alone() -> None:
    shown = dir(gb)
    assert [name for name in shown if not name.startswith("__")] == sorted(gb.__all__)
    assert {"__all__", "__doc__", "__name__", "__version__"} <= set(shown)
    assert all(hasattr(gb, name) for name in shown)


@pytest.mark.parametrize("room", ["solver", "blocks", "language"])
def test_a_room_is_no_public_name_but_can_be_reached(room: str) -> None:
    assert room not in dir(gb)
    assert getattr(gb, room).__name__ == f"gearblocks.{room}"


def test_public_functions_stay_what_they_are_when_every_module_is_imported() -> None:
    assert set(FUNCTIONS) <= set(gb.__all__)
    done = subprocess.run(
        [sys.executable, "-c", IMPORT_ALL, *FUNCTIONS], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split("\n")[:4] == ["hidden: []", "modules: []", "not callable: []", "changed: []"]


def test_names_are_imported_from_where_type_checkers_see_them() -> None:
    tree = ast.parse(Path(gb.__file__).read_text(encoding="utf-8"))
    typed = next(x for x in tree.body if isinstance(x, ast.If)).body
    seen = {a.name: x.module for x in typed if isinstance(x, ast.ImportFrom) for a in x.names}
    assert seen == {name: f"gearblocks.{module}" for name, module in gb._HOME.items()}
    assert sorted(seen) == sorted(gb.__all__)
    assert all(getattr(gb, name).__module__.startswith(("gearblocks.", "builtins")) for name in ("Shaft", "sweep"))


def test_what_is_no_name_is_refused_as_by_any_module() -> None:
    with pytest.raises(AttributeError, match="module 'gearblocks' has no attribute 'Shafts'"):
        gb.Shafts  # noqa: B018
    assert not hasattr(gb, "_HOMES") and not hasattr(gb, "__path_")


HEAVY = "gearblocks.analysis", "numpy", "scipy", "sympy", "matplotlib", "xarray", "jinja2", "dask"


@pytest.mark.parametrize(
    ("asked", "allowed"),
    [
        ("import gearblocks", ()),
        ("from gearblocks.cli.main import main; main(['--help'])", ()),
        ("import gearblocks as gb; gb.GearblocksError, dir(gb)", ()),
        ("import gearblocks as gb; gb.Drivetrain, gb.Shaft, gb.simulate", ("numpy",)),
    ],
)
def test_what_is_not_used_is_not_imported(asked: str, allowed: tuple[str, ...]) -> None:
    words = f"{asked}\nimport sys; print([name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == str([name for name in HEAVY if name in allowed])
