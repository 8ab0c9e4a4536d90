"""Lessons in JupyterLab: notebooks made from the lessons, labs and questions as widgets."""
