"""Geometry of gears, in numbers or symbols. Knows nothing of blocks."""
