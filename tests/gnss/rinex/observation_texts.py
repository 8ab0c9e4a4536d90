"""Small RINEX observation files written by hand, for the tests beside."""


def header_line(text, label):
    """One header line: text in columns 1 to 60, the label from column 61 on."""
    return f"{text:<60}{label}"


def header2(types, version="2.11", system="G", extra=()):
    """Header of a RINEX 2 file with the observation types given."""
    chunks = [types[at : at + 9] for at in range(0, len(types), 9)]
    starts = [f"{len(types):6d}"] + [" " * 6] * len(chunks)
    lists = [start + "".join(f"    {kind}" for kind in chunk) for start, chunk in zip(starts, chunks, strict=False)]
    return [
        header_line(f"     {version}           OBSERVATION DATA    {system}", "RINEX VERSION / TYPE"),
        *(header_line(text, "# / TYPES OF OBSERV") for text in lists),
        *extra,
        header_line("", "END OF HEADER"),
    ]


def header3(types, version="3.04", system="M", scale="GPS", extra=()):
    """Header of a RINEX 3 file; types: system letter -> observation codes, at most 13 each."""
    return [
        header_line(f"     {version}           OBSERVATION DATA    {system}", "RINEX VERSION / TYPE"),
        *(header_line(f"{letter}  {len(codes):3d} {' '.join(codes)}", "SYS / # / OBS TYPES") for letter, codes in types.items()),
        header_line(f"  2024     1     1     0     0    0.0000000     {scale:<3}", "TIME OF FIRST OBS"),
        *extra,
        header_line("", "END OF HEADER"),
    ]


def epoch3(second, count, flag=0, rest=""):
    """Epoch line of RINEX 3 at 2024-01-01 00:00 and a second."""
    return f"> 2024 01 01 00 00{second:11.7f}  {flag}{count:3d}{rest}"


def text_of(*parts, newline="\n"):
    """One text from lines and lists of lines, each ended by a line end."""
    lines = [line for part in parts for line in ([part] if isinstance(part, str) else part)]
    return "".join(line + newline for line in lines)


SMALL3 = text_of(
    header3({"G": ("C1C", "L1C", "D1C", "S1C"), "E": ("C1X", "L1X")}),
    epoch3(0, 3),
    "G05  20000000.123 7 105000000.45617     -1234.567          45.250",
    "G12  21000000.000                                          40.000",
    "E03  25000000.125   131000000.50003",
    epoch3(1, 2),
    "G05  20000100.123 7 105000525.987 7     -1235.000          45.500",
    "E03  25000010.125   131000052.50003",
)
SMALL2 = text_of(
    header2(("C1", "L1", "L2", "P2", "S1", "S2"), system="M"),
    " 24  1  1  0  0  0.0000000  0  2G05R03",
    "  20000000.123 7 105000000.45617  81818181.12345  20000001.000          45.250",
    "        40.000",
    "  19000000.123   101000000.000    78000000.500    19000002.000          44.000",
    "        41.000",
    " 24  1  1  0  0  1.0000000  0  1G05",
    "  20000100.123 7 105000525.987 7  81818590.500    20000101.000          45.500",
    "        40.500",
)
