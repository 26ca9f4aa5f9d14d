"""The public names: what dir shows, and that no inner module hides one of them."""

import subprocess
import sys

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
