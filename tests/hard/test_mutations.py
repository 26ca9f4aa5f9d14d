"""The list of mutations fits the sources."""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from pathlib import Path
from runpy import run_path

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


def test_the_readme_has_the_table_of_the_list() -> None:
    module = run_path(str(HERE / "mutations.py"))
    assert module["table"]() in (HERE / "README.md").read_text(encoding="utf-8"), (
        "python tests/hard/mutations.py --table"
    )


def test_every_subject_has_its_share() -> None:
    counts = Counter(mutation["subject"] for mutation in MUTATIONS)
    assert len(MUTATIONS) >= 120 and len({mutation["name"] for mutation in MUTATIONS}) == len(MUTATIONS)
    assert set(counts) == {"constraints", "error control", "events", "FMU glue", "laws", "ledger", "outputs"}
    assert min(counts.values()) >= 15, counts
