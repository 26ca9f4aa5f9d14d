"""Equations for people."""
