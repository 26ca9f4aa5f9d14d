"""Measurements: gearblocks and its peers side by side, one problem a module, `python -m benchmarks.<name>`."""
