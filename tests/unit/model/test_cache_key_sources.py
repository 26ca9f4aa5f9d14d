"""The keys of the cache see every source that a program and the core are made of, whatever its folder."""

import ast
import shutil
from pathlib import Path

import pytest

from gearblocks.model.cache_key import PACKAGE, package_digest
from gearblocks.solver.library import METHOD_SOURCES, core_digest, core_sources

ROOMS = sorted(path.parent.relative_to(PACKAGE).as_posix() for path in PACKAGE.rglob("__init__.py"))
TEMPLATES = sorted(path.relative_to(PACKAGE).as_posix() for path in PACKAGE.rglob("*.jinja"))


def _of_every_room() -> list[str]:
    """One file of each room that has any besides its __init__.py, and the templates."""
    first = [
        sorted((PACKAGE / room).glob("*.py"), key=lambda p: (p.name == "__init__.py", p.name))[0] for room in ROOMS
    ]
    return [*(path.relative_to(PACKAGE).as_posix() for path in first), *TEMPLATES]


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("sources") / "gearblocks"
    shutil.copytree(PACKAGE, target, ignore=shutil.ignore_patterns("__pycache__"))
    return target


def _digest_with(copy: Path, file: str, data: bytes | None) -> str:
    """The digest of a copy of the package in which one file has another content, or is gone."""
    path, before = copy / file, (copy / file).read_bytes()
    try:
        if data is None:
            path.unlink()
        else:
            path.write_bytes(data)
        return package_digest.__wrapped__(copy)
    finally:
        path.write_bytes(before)


def test_the_key_depends_on_contents_and_not_on_where_the_package_lies(copy: Path) -> None:
    assert package_digest.__wrapped__(copy) == package_digest()


@pytest.mark.parametrize("file", _of_every_room())
@pytest.mark.few(6)
def test_one_changed_byte_of_any_room_changes_the_key_of_programs(copy: Path, file: str) -> None:
    data = (copy / file).read_bytes()
    assert _digest_with(copy, file, data[:-1] + bytes([data[-1] ^ 1])) != package_digest()


def test_a_file_that_moves_to_another_room_or_goes_changes_the_key_of_programs(copy: Path) -> None:
    # two rooms have files of one name: their contents, exchanged, are another package
    one, other = copy / "codegen/massless_groups.py", copy / "assembly/massless_groups.py"
    texts = one.read_bytes(), other.read_bytes()
    try:
        one.write_bytes(texts[1])
        other.write_bytes(texts[0])
        assert package_digest.__wrapped__(copy) != package_digest()
    finally:
        one.write_bytes(texts[0])
        other.write_bytes(texts[1])
    assert _digest_with(copy, "codegen/layout.py", None) != package_digest()


def test_one_changed_byte_of_any_file_of_the_core_changes_the_key_of_the_core() -> None:
    sources = core_sources(PACKAGE / "solver")
    assert {path.name for path in (PACKAGE / "solver" / "c").iterdir()} <= set(sources)
    key = core_digest(sources)
    for name, data in sources.items():
        assert core_digest({**sources, name: data[:-1] + bytes([data[-1] ^ 1])}) != key, name


def test_the_key_of_the_core_sees_all_that_the_tables_of_its_methods_come_from() -> None:
    waiting, seen = ["methods.py"], set[str]()
    while waiting:
        name = waiting.pop()
        seen.add(name)
        tree = ast.parse((PACKAGE / "solver" / name).read_text(encoding="utf-8"))
        modules = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
        ours = [module.split(".") for module in modules if module.startswith("gearblocks.")]
        assert all(parts[:2] == ["gearblocks", "solver"] for parts in ours), name
        waiting += [f"{parts[2]}.py" for parts in ours if f"{parts[2]}.py" not in seen]
    assert seen == set(METHOD_SOURCES)
