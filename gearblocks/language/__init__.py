"""The language that blocks are written in."""
