"""Draws the kinematic schemes of the README into docs/pictures/: its own spur pair, and shipped models.

python docs/draw_trains.py
"""

from __future__ import annotations

import re
from pathlib import Path

from gearblocks.cli import scripts
from gearblocks.drivetrain import Drivetrain
from gearblocks.files import write_text

DOCS = Path(__file__).parent
PICTURES = DOCS / "pictures"
MODELS = {"scheme_gearbox.svg": "automatic_gearbox"}


def quickstart() -> Drivetrain:
    """The train of the README's first example, made by its own lines up to the equations."""
    readme = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"<!-- tested -->\n```python\n(.*?)```", readme, flags=re.DOTALL)
    scope: dict[str, object] = {}
    exec(blocks[0].partition("\neq = ")[0], scope)  # noqa: S102  the README's own code
    rig = scope["rig"]
    assert isinstance(rig, Drivetrain)
    return rig


def pictures() -> dict[str, str]:
    """File names in docs/pictures/ and what belongs in them."""
    drawn = {name: str(scripts.make(model).draw()) for name, model in MODELS.items()}
    return {"scheme_spur_pair.svg": str(quickstart().draw()), **drawn}


if __name__ == "__main__":
    for name, text in pictures().items():
        write_text(PICTURES / name, text)
        print(f"wrote {PICTURES / name}")
