"""Save this: the picture, its numbers, and the link that brings the controls back."""

import csv
import io

import numpy as np

from gnsslab.labs.links import query_of

MIME_TYPES = {"png": "image/png", "svg": "image/svg+xml", "csv": "text/csv"}


def saved(desk, kind):
    """Return what is on the desk as a file of that kind, "png", "svg" or "csv": bytes."""
    if kind == "csv":
        return table_text(desk.lab.table(desk.result)).encode("utf-8")
    from gnsslab.figures.kept import styled

    figure, out = desk.lab.figure(desk.result), io.BytesIO()
    with styled():
        figure.savefig(out, format=kind)
    return out.getvalue()


def table_text(columns):
    """Return columns {name: (T,) values} as CSV: nothing where there is no number.

    >>> print(table_text({"second": np.array([0, 1]), "heading_deg": np.array([35.5, np.nan])}), end="")
    second,heading_deg
    0,35.5
    1,
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*([_cell(value) for value in column] for column in columns.values()), strict=True))
    return out.getvalue()


def link_of(lesson, desk):
    """Return the path and query that open the lesson with the desk's controls."""
    return f"{lesson.address}?{query_of(desk.lab, desk.settings)}"


def _cell(value):
    if isinstance(value, np.datetime64):
        return np.datetime_as_string(value, unit="ms")
    if isinstance(value, (float, np.floating)):
        return "" if np.isnan(value) else f"{value:.9g}"
    return str(value)
