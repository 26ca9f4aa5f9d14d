"""Kinematic schemes: a train drawn in the symbols of ISO 3952 and of gearbox textbooks, as SVG. Knows nothing of laws."""
