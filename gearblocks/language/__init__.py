"""The language that blocks are written in. Knows nothing of sympy, nor of trains."""
