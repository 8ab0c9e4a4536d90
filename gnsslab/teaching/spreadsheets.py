"""Cells of CSV files that a spreadsheet will open: text stays text."""

FORMULA_STARTS = "=+-@\t\r\uff1d\uff0b\uff0d\uff20"  # a spreadsheet runs what starts with one of these, the wide ones too


def harmless(text):
    """Return a text that no spreadsheet takes for a formula; a number stays as it is.

    >>> harmless("=1+1"), harmless("-3.5"), harmless("Ann")
    ("'=1+1", '-3.5', 'Ann')
    """
    return f"'{text}" if text.lstrip(" ").startswith(tuple(FORMULA_STARTS)) and not _is_number(text) else text


def _is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True
