"""Worksheets: notebooks with blanks, written, read, run and marked."""
