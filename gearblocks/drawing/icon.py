"""Icon of a train: its drawing without words as a small PNG (ISO/IEC 15948), as tools show an FMU in their browser.

Each line is the set of pixels nearer to it than half its width, with a soft edge of one pixel. Knows nothing of trains.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gearblocks.drawing.layout import Layout
from gearblocks.drawing.shapes import FILLED, PAPER, THIN, Circle, Point, Stroke, arc

SIZE, BORDER, INK = 192, 8, 28
"""Pixels of the longer side, of the border around, and the grey of lines."""


def png(layout: Layout) -> bytes:
    """The picture as the bytes of a file."""
    scale = (SIZE - 2 * BORDER) / max(layout.width, layout.height)
    width, height = (max(32, round(side * scale) + 2 * BORDER) for side in (layout.width, layout.height))
    paper = np.ones((height, width))
    for points, thin, white in _lines(layout):
        at = np.array(points) * scale + BORDER
        if white:
            _fill(paper, at)
        for a, b in pairwise(at):
            _line(paper, a, b, 0.9 if thin else 1.3)
    return _encoded(np.round(INK + (255 - INK) * paper).astype(np.uint8))


def _lines(layout: Layout) -> Iterator[tuple[tuple[Point, ...], bool, bool]]:
    """Points of every line, whether it is thin, and whether it bounds a white surface."""
    yield from ((wire.points, False, False) for wire in layout.wires)
    for shape in (shape for figure in layout.figures for shape in figure.shapes):
        if isinstance(shape, Circle):
            yield arc(shape.x, shape.y, shape.r, 0, 360).points, shape.look == THIN, shape.look == PAPER
        elif isinstance(shape, Stroke):
            points = (*shape.points, shape.points[0]) if shape.closed else shape.points
            yield points, shape.look in (THIN, FILLED), shape.look == PAPER


def _window(paper: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64]) -> tuple[slice, slice]:
    """The part of the paper around a line."""
    x, y = (slice(max(0, int(low[k]) - 2), min(paper.shape[1 - k], int(high[k]) + 3)) for k in (0, 1))
    return y, x


def _line(paper: NDArray[np.float64], a: NDArray[np.float64], b: NDArray[np.float64], width: float) -> None:
    part = _window(paper, np.minimum(a, b), np.maximum(a, b))
    y, x = np.mgrid[part]
    along = b - a
    share = np.clip(((x + 0.5 - a[0]) * along[0] + (y + 0.5 - a[1]) * along[1]) / max(along @ along, 1e-12), 0, 1)
    apart = np.hypot(x + 0.5 - a[0] - share * along[0], y + 0.5 - a[1] - share * along[1])
    paper[part] = np.minimum(paper[part], np.clip(apart - width / 2 + 0.5, 0, 1))


def _fill(paper: NDArray[np.float64], corners: NDArray[np.float64]) -> None:
    """Whitens the box around a surface."""
    paper[_window(paper, corners.min(axis=0) + 2, corners.max(axis=0) - 3)] = 1.0


def _encoded(grey: NDArray[np.uint8]) -> bytes:
    height, width = grey.shape
    rows = b"".join(b"\0" + row.tobytes() for row in grey)
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b""))
    parts = (
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)
