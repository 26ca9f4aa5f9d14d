"""Equations of a train, written out for people. Knows nothing of C."""
