"""Interactive experiments as data and functions; no front end is imported here."""
