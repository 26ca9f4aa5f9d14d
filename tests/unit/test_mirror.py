"""Every file of the package has a test file of its name, or a row in tests/README.md that names the tests that hold it."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "gearblocks"
TESTS = ROOT / "tests"
ROW = re.compile(r"^\| ((?:`[^`]+\.py`|`[^`]+/`)(?:, `[^`]+`)*) \| (.+) \|$", re.M)


def _names(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


TABLE = (TESTS / "README.md").read_text(encoding="utf-8").split("\n## Files without a test file of their name\n")[1]
ROWS = [(_names(files), _names(tests)) for files, tests in ROW.findall(TABLE)]
LISTED = [name for files, _ in ROWS for name in files]
FILES = [path.relative_to(PACKAGE) for path in sorted(PACKAGE.rglob("*.py")) if not path.name.startswith("__")]


def _mirrored(file: Path) -> bool:
    return (TESTS / "unit" / file.parent / f"test_{file.name}").is_file()


def _in_table(file: Path) -> bool:
    return file.as_posix() in LISTED or any(f"{parent.as_posix()}/" in LISTED for parent in file.parents)


def test_a_file_of_the_package_has_a_test_file_of_its_name_or_a_row_in_the_readme() -> None:
    neither_or_both = [file.as_posix() for file in FILES if _mirrored(file) == _in_table(file)]
    assert neither_or_both == [], "give it a test file of its name, or a row; not both"


def test_every_row_of_the_readme_names_files_and_tests_that_there_are() -> None:
    assert len(ROWS) == TABLE.count("\n| `")
    assert len(LISTED) == len(set(LISTED))
    assert [name for name in LISTED if not (PACKAGE / name).exists()] == []
    assert [name for _, tests in ROWS for name in tests if not (TESTS / name).exists()] == []
    assert all(tests for _, tests in ROWS)


def test_every_folder_and_file_of_the_overview_is_there() -> None:
    overview = (TESTS / "README.md").read_text(encoding="utf-8").split("\n## Where to look\n")[1].split("\n## ")[0]
    places = {name for name in _names(overview) if name.endswith("/")}
    assert {name for name in places if not (TESTS / name).is_dir()} == set()
    physics = {f"physics/{path.name}/" for path in (TESTS / "physics").iterdir() if path.name != "__pycache__"}
    assert physics <= places


def test_a_test_file_can_be_read_in_one_go() -> None:
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in TESTS.rglob("*.py")}
    assert [path.relative_to(TESTS).as_posix() for path, number in lines.items() if number > 400] == [], (
        "split by subject"
    )
