"""The symbolic law of one kind of block."""
