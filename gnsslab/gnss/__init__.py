"""Satellites, receivers and measurements."""
