"""Every page of equations in a browser, at the widths of a screen and of a telephone: `pages.py BROWSER`.

No page may be wider than its window, no symbol of a table wider than its cell, and on a screen no equation wider than its
column. Prints what is, and ends with 1.
"""

import html
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from gearblocks.cli import scripts

SCREEN, WIDTHS = 1280, (1280, 390)
LOOK = """<title></title><iframe width="{width}" height="2000" frameborder="0" srcdoc="{page}"></iframe><script>
onload = () => {{
  const page = document.querySelector("iframe").contentDocument, root = page.documentElement;
  const cut = x => x.scrollWidth > x.clientWidth + 1;
  const wide = [...page.querySelectorAll(".equation")].filter(x => cut(x.children[0]));
  const names = wide.map(x => x.querySelector(".of")?.textContent ?? "one without a number");
  const right = x => x.getBoundingClientRect().right;
  const leaves = (x, within) => [...x.querySelectorAll("math *")].some(y => right(y) > within + 1);
  const over = [...page.querySelectorAll("td")].filter(x => leaves(x, right(x)));
  const cells = over.map(x => x.textContent.trim().replace(/\\s+/g, "_"));
  document.title = ["seen", root.clientWidth, root.scrollWidth, names.join(" "), "cells", cells.join(" ")].join(" ");
}};
</script>"""


def look(browser: str, page: Path, width: int) -> str:
    """What is wrong with a page in a frame of a width, or the empty text."""
    command = [
        browser,
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--hide-scrollbars",
        "--window-size=1600,2000",
        "--dump-dom",
    ]
    dom = subprocess.run([*command, page.as_uri()], capture_output=True, text=True, check=False, timeout=120).stdout
    found = re.search(r"<title>seen (\d+) (\d+) (.*) cells (.*)</title>", dom)
    if found is None:
        return "the browser did not show it"
    inner, needed, wide, cells = int(found[1]), int(found[2]), found[3], found[4]
    if inner != width:
        return f"the frame is {inner} px wide"
    if needed > inner:
        return f"it needs {needed} px"
    if cells:
        return f"{cells} wider than the cell of a table"
    return f"{wide} wider than the column" if wide and width == SCREEN else ""


def main(browser: str) -> int:
    """Exit status."""
    models = [f"{n}:{maker.name}" for n in scripts.shipped() for maker in scripts.makers(scripts.locate(n)[0])]
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "equations.html"
        for model in models:
            equations = html.escape(scripts.make(model).equations().html())
            for width in WIDTHS:
                page.write_text(LOOK.format(width=width, page=equations), encoding="utf-8")
                wrong = look(browser, page, width)
                failed += bool(wrong)
                if wrong:
                    print(f"{model} at {width} px: {wrong}")
    print(f"{len(models)} pages at {len(WIDTHS)} widths, {failed} wrong")
    return 1 if failed or not models else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
