"""Equations of a train, written out for people."""
