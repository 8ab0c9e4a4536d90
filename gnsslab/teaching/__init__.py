"""Fronts, course server, doctor."""
