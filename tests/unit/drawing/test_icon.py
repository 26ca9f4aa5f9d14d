"""The icon of a drawing as PNG."""

import struct
import zlib

import numpy as np

import gearblocks as gb
from gearblocks.drawing.icon import SIZE, png


def _pixels(data: bytes) -> np.ndarray:
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, found = 8, {}
    while at < len(data):
        (n,) = struct.unpack(">I", data[at : at + 4])
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + n]
        assert struct.unpack(">I", data[at + 8 + n : at + 12 + n])[0] == zlib.crc32(kind + body)
        found[kind], at = body, at + 12 + n
    width, height = struct.unpack(">II", found[b"IHDR"][:8])
    rows = np.frombuffer(zlib.decompress(found[b"IDAT"]), dtype=np.uint8).reshape(height, width + 1)
    assert not rows[:, 0].any()
    return rows[:, 1:]


def test_the_icon_is_a_small_grey_picture_with_the_shaft_as_a_dark_line() -> None:
    rig = gb.Drivetrain("two discs")
    rig.chain(rig.add("a", gb.Inertia(J=1.0)), rig.add("s", gb.Shaft(k=1.0)), rig.add("b", gb.Inertia(J=1.0)))
    layout = rig.draw().layout
    pixels = _pixels(png(layout))
    assert max(pixels.shape) == SIZE and pixels[0].min() == 255
    (x0, y), (x1, _) = layout.wires[0].points
    scale = (SIZE - 16) / layout.width
    assert pixels[int(y * scale + 8), int((x0 + x1) / 2 * scale + 8)] < 100
    assert 0.01 < np.mean(pixels < 128) < 0.3
