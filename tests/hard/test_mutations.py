"""The list of mutations fits the sources."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
MUTATIONS = tomllib.loads((HERE / "mutations.toml").read_text(encoding="utf-8"))["mutation"]


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda mutation: mutation["name"])
def test_a_mutation_fits_the_source_once_and_names_tests_that_there_are(mutation: dict[str, object]) -> None:
    file, text, tests = str(mutation["file"]), str(mutation["text"]), mutation["tests"]
    assert (ROOT / file).read_text(encoding="utf-8").count(text) == 1, f"{file} has not once: {text}"
    assert text != mutation["becomes"]
    assert isinstance(tests, list) and tests
    for test in tests:
        where, name = test.split("::")
        function = re.escape(name.split("[")[0])
        assert re.search(rf"^def {function}\(", (ROOT / where).read_text(encoding="utf-8"), re.M), test


def test_the_readme_lists_every_mutation_once() -> None:
    listed = re.findall(r"^\| `([^`]+)` \|", (HERE / "README.md").read_text(encoding="utf-8"), re.M)
    assert listed == [mutation["name"] for mutation in MUTATIONS]
