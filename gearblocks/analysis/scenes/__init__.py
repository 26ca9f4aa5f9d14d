"""Scenes: what accuracy costs, what an effect costs and changes, and what a scene calls for."""
