"""Geometry of gears, in numbers or symbols."""
