"""The demo, from an empty folder to a page that holds together."""

from __future__ import annotations

import csv
from pathlib import Path
from urllib.parse import unquote

import pytest
from lxml import html

from gearblocks.cli.demo import _first_of_each
from gearblocks.cli.main import main

EXPECTED = {"300 rpm": "period 1", "348 rpm": "period 2", "360 rpm": "period 5", "1080 rpm": "chaotic"}


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("leerer Ordner für die Vorführung") / "out"
    assert main(["demo", "--out", str(out)]) == 0
    return out / "index.html"


def links(page: Path) -> list[str]:
    tree = html.fromstring(page.read_text(encoding="utf-8"))
    return [str(link) for _, _, link, _ in tree.iterlinks()]


@pytest.mark.long
@pytest.mark.parametrize("name", ["index.html", "equations.html"])
def test_the_pages_need_no_network(page: Path, name: str) -> None:
    text = page.with_name(name).read_text(encoding="utf-8")
    assert 'src="http' not in text and 'href="http' not in text and "<script" not in text and "@import" not in text


@pytest.mark.long
def test_every_link_leads_to_a_file_and_every_file_is_linked(page: Path) -> None:
    found = {unquote(link) for link in links(page)}
    files = {path.name for path in page.parent.iterdir()}
    assert found <= files
    assert files - found == {"index.html"}


@pytest.mark.long
def test_the_regimes_of_set_s_are_found(page: Path) -> None:
    tree = html.fromstring(page.read_text(encoding="utf-8"))
    rows = [[cell.text_content() for cell in row.findall("td")] for row in tree.findall(".//table")[0].findall("tr")]
    assert {row[0]: row[2] for row in rows if row} == EXPECTED


@pytest.mark.long
def test_the_equations_are_shown_in_both_forms(page: Path) -> None:
    tree = html.fromstring(page.with_name("equations.html").read_text(encoding="utf-8"))
    headings = [heading.text for heading in tree.findall(".//h2")]
    assert "Angle form" in headings and "Relative form" in headings
    assert len(tree.findall(".//math")) > 10


@pytest.mark.long
def test_the_cost_falls_with_the_error_and_locating_corners_pays(page: Path) -> None:
    with page.with_name("cost.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    error = next(name for name in rows[0] if name.startswith("error of peak(spline.force"))
    best = {
        (method, located): min(
            float(row[error]) for row in rows if (row["method"], row["located"]) == (method, located)
        )
        for method in ("dp8", "dp5", "rk4")
        for located in "01"
    }
    assert best["dp8", "1"] < 1e-8  # asked for 1e-10
    assert all(best[method, "1"] < best[method, "0"] for method in ("dp5", "rk4"))


@pytest.mark.long
def test_the_check_of_the_fmu_is_passed(page: Path) -> None:
    assert "passed" in page.with_name("check.txt").read_text(encoding="utf-8").splitlines()[0]


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("not a folder")
    assert main(["demo", "--out", str(tmp_path / "file" / "out")]) == 2
    assert "cannot make the folder" in capsys.readouterr().err


def test_the_runs_of_a_work_precision_study_are_told_once_for_each_accuracy() -> None:
    said: list[str] = []
    tell = _first_of_each(said.append)
    for accuracy in ("rtol 0.01", "rtol 0.001", "step 0.1 s"):
        for method in ("dp8", "dp5", "rodas"):
            tell(f"{method}, {accuracy}")
            tell(f"{method}, {accuracy}, events not located")
    tell("reference")
    assert said == [f"what accuracy costs: {x}" for x in ("rtol 0.01", "rtol 0.001", "step 0.1 s", "reference")]
