"""From truth to measurements."""
