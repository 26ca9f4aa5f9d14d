"""The symbolic law of one kind of block. Knows nothing of trains."""
