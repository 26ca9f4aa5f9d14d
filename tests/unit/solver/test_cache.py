"""The cache never loses an entry, never hands out a damaged one, and never stops the work."""

import multiprocessing
import os
import time
import warnings
from pathlib import Path

import pytest

from gearblocks.errors import GearblocksWarning
from gearblocks.solver.cache import Cache, digest, user_cache


def test_what_was_written_is_found_by_another_process(tmp_path: Path) -> None:
    path = Cache(tmp_path).write("models", "key", b"content", ".so")
    again = Cache(tmp_path)
    assert again.find("models", "key", ".so") == path
    assert path.suffix == ".so"
    assert again.read("models", "other") is None


@pytest.mark.parametrize("damage", [b"", b"conten", b"tnetnoc", b"content and more"])
def test_a_damaged_entry_counts_as_absent_and_is_written_again(tmp_path: Path, damage: bytes) -> None:
    cache = Cache(tmp_path)
    cache.write("models", "key", b"content").write_bytes(damage)
    assert cache.read("models", "key") is None
    cache.write("models", "key", b"content")
    assert cache.read("models", "key") == b"content"


@pytest.mark.parametrize("damage", [b"", b"0 1 2 3", b"\xff\xfe", b"0123 seven"])
def test_a_damaged_pointer_counts_as_absent(tmp_path: Path, damage: bytes) -> None:
    cache = Cache(tmp_path)
    cache.write("models", "key", b"content")
    (tmp_path / "models" / "key.ref").write_bytes(damage)
    assert cache.read("models", "key") is None


def _write_often(root: Path, number: int) -> int:
    cache, seen = Cache(root), 0
    for turn in range(100):
        cache.write("models", "key", b"%d of %d" % (turn, number) * 1000)
        seen += cache.read("models", "key") is not None
    return seen


def test_writers_of_one_entry_do_not_disturb_each_other(tmp_path: Path) -> None:
    with multiprocessing.get_context("spawn").Pool(3) as pool:
        seen = pool.starmap(_write_often, [(tmp_path, number) for number in range(3)])
    assert seen == [100, 100, 100]
    assert not list(tmp_path.glob("**/.tmp-*"))


def test_a_cache_that_cannot_be_written_is_replaced_with_one_warning(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("a file where the directory should be")
    cache = Cache(tmp_path / "file")
    with pytest.warns(GearblocksWarning, match="cannot be written") as seen:
        first = cache.write("models", "key", b"content")
        cache.write("models", "other", b"more")
        cache.folder("zig")
    assert len(seen) == 1
    assert str(tmp_path / "file") in str(seen[0].message)
    assert "GEARBLOCKS_CACHE" in str(seen[0].message)
    assert cache.find("models", "key") == first
    assert cache.read("models", "other") == b"more"


def test_a_full_disk_is_told_by_name_and_the_entry_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = os.replace

    def full(source: str, target: Path) -> None:
        if tmp_path in Path(target).parents:
            raise OSError(28, "No space left on device")
        real(source, target)

    monkeypatch.setattr(os, "replace", full)
    cache = Cache(tmp_path)
    with pytest.warns(GearblocksWarning, match="no space left on device"):
        cache.write("models", "key", b"content")
    assert cache.read("models", "key") == b"content"
    assert not list(tmp_path.glob("**/.tmp-*"))


def test_what_dead_writers_left_is_removed(tmp_path: Path) -> None:
    folder = tmp_path / "models"
    folder.mkdir()
    old, young = folder / ".tmp-old", folder / ".tmp-young"
    for path in (old, young):
        path.write_bytes(b"half an entry")
    os.utime(old, (time.time() - 86400.0,) * 2)
    Cache(tmp_path).write("models", "key", b"content")
    assert young.exists()
    assert not old.exists()


def test_the_environment_names_the_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = tmp_path / "käfig mit platz"
    monkeypatch.setenv("GEARBLOCKS_CACHE", str(place))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert place in user_cache().write("models", "key", b"content").parents


def test_a_digest_tells_where_its_parts_end() -> None:
    assert digest("ab", "c") != digest("a", "bc")
    assert digest("ab", b"c") == digest(b"ab", "c")
