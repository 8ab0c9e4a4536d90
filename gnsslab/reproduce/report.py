"""The report: one HTML file that needs nothing else, and the same lines as JSON."""

import json
from base64 import b64encode
from html import escape

from gnsslab.reproduce.papers import table_lines
from gnsslab.reproduce.rule import GOOD, NEAR, RULE

COLUMNS = ("item", "quantity", "paper", "ours, median", "mean ± sd", "verdict")
_STYLE = """
:root { color-scheme: light dark; --ink: #1c1c1c; --paper: #ffffff; --line: #d0d0d0; --soft: #5a5a5a;
  --good: #006b4f; --near: #8a5a00; --bad: #a3246b }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e8e8; --paper: #181a1c; --line: #44484c; --soft: #b0b4b8;
    --good: #4fc79b; --near: #e8a83c; --bad: #f08cc0 } }
body { font: 16px/1.45 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 62rem; margin: 0 auto; padding: 1rem }
h1 { font-size: 1.5rem } h2 { font-size: 1.2rem; margin-top: 2.2rem } h3 { font-size: 1.05rem; margin-top: 1.8rem }
table { border-collapse: collapse; width: 100%; font-size: .9rem }
th, td { text-align: left; vertical-align: top; padding: .35rem .5rem; border-bottom: 1px solid var(--line) }
td small { display: block; color: var(--soft) }
.good { color: var(--good) } .near { color: var(--near) } .bad { color: var(--bad) } .verdict { font-weight: 600 }
figure { margin: 1.2rem 0 } img { display: block; width: 100%; max-width: 32rem; border-radius: 6px }
figcaption { color: var(--soft); max-width: 32rem }
@media (max-width: 40rem) {
  thead { display: none } tr { display: block; padding: .5rem 0; border-bottom: 1px solid var(--line) }
  tbody th { display: block; border: 0; padding: .1rem 0 }
  td { display: block; border: 0; padding: .1rem 0 } td[data-name]::before { content: attr(data-name) ": "; color: var(--soft) } }
"""


def report_json(reproductions):
    """Return the report as JSON text: a list of lines, one for each stated number or claim, then one for each number of our tables."""
    return (
        json.dumps([line for each in reproductions for line in [*each.lines, *each.measured]], indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    )


def report_html(reproductions, made_by):
    """Return the report as HTML text: for each paper its verdicts, a table, and its figures made again. `made_by` says how to make it again."""
    body = "".join(_paper(each) for each in reproductions)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Papers reproduced</title><style>{_STYLE}</style></head>\n<body><h1>Papers reproduced</h1>\n"
        f"<p>{escape(RULE)}</p>\n<p>Made by <code>{escape(made_by)}</code></p>\n{body}</body></html>\n"
    )


def tally(lines):
    """Return how many lines have which verdict, in words.

    >>> tally([{"verdict": "near"}, {"verdict": "reproduced"}, {"verdict": "near"}])
    '2 near, 1 reproduced'
    """
    words = [line["verdict"] for line in lines]
    return ", ".join(f"{words.count(word)} {word}" for word in sorted(set(words), key=lambda word: (-words.count(word), word)))


def _paper(one):
    notes = "".join(f"<li>{escape(note)}</li>" for note in one.notes)
    head = "".join(f'<th scope="col">{name}</th>' for name in COLUMNS)
    rows = "\n".join(_row(line) for line in one.lines)
    tables = "\n".join(_table(one.letter, table) for table in one.tables)
    beyond = f"<h2>Not in paper {one.letter}</h2>\n{tables}\n" if tables else ""
    pictures = "\n".join(_picture(picture) for picture in one.pictures)
    return (
        f"<h2>Paper {one.letter}</h2>\n<p>{escape(one.title)}</p>\n<p>{tally(one.lines)}</p>\n<ul>{notes}</ul>\n"
        f"<table><thead><tr>{head}</tr></thead>\n<tbody>{rows}</tbody></table>\n{beyond}<h2>Figures of paper {one.letter}</h2>\n{pictures}\n"
    )


def _row(line):
    kind = "good" if line["verdict"] in GOOD else "near" if line["verdict"] == NEAR else "bad"
    cause = f"<small>{escape(line['cause'])}</small>" if line["cause"] else ""
    cells = (
        f"<td>{escape(line['item'])}</td>", f"<td>{escape(line['quantity'])}</td>",
        f'<td data-name="paper">{_paper_words(line)}<small>{escape(line["source"])}</small></td>',
        f'<td data-name="ours, median">{_with_unit(_words(line["ours_median"]), line["unit"])}</td>',
        f'<td data-name="mean ± sd">{_spread(line)}</td>',
        f'<td data-name="verdict"><span class="verdict {kind}">{line["verdict"]}</span>{cause}</td>',
    )  # fmt: skip
    return f"<tr>{''.join(cells)}</tr>"


def _table(letter, table):
    """Return a table of ours: medians with mean and standard deviation below them, means alone of shares."""
    names = [escape(f"{column.quantity} [{column.unit}]" if column.unit else column.quantity) for column in table.columns]
    lines = table_lines(letter, table)
    rows = [(name, lines[start : start + len(names)]) for name, start in zip(table.rows, range(0, len(lines), len(names)), strict=True)]
    head = "".join(f'<th scope="col">{name}</th>' for name in ("", *names))
    body = "\n".join(_table_row(name, "".join(map(_cell, table.columns, names, cells))) for name, cells in rows)
    return f"<h3>{escape(table.title)}</h3>\n<p>{escape(table.words)}</p>\n<table><thead><tr>{head}</tr></thead>\n<tbody>{body}</tbody></table>"


def _table_row(name, cells):
    return f'<tr><th scope="row">{escape(name)}</th>{cells}</tr>'


def _cell(column, name, line):
    value = line["ours_mean"] if column.is_share else line["ours_median"]
    has_spread = line["seeds"] > 1 and line["ours_mean"] is not None and not column.is_share
    spread = f"<small>{_words(line['ours_mean'])} ± {_words(line['ours_sd'])}</small>" if has_spread else ""
    return f'<td data-name="{name}">{_words(value)}{spread}</td>'


def _paper_words(line):
    value = line["paper_value"]
    if not isinstance(value, list):
        return _with_unit(_words(value), line["unit"])
    low, high = value
    words = f"{_words(low)} or more" if high is None else f"{_words(high)} or less" if low == 0 else f"{_words(low)} to {_words(high)}"
    return _with_unit(words, line["unit"])


def _spread(line):
    if line["seeds"] < 2:
        return ""
    return f"{_words(line['ours_mean'])} ± {_words(line['ours_sd'])}<small>{line['seeds']} seeds</small>"


def _with_unit(words, unit):
    return escape(f"{words} {unit}".rstrip())


def _words(value):
    return "none" if value is None else f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def _picture(picture):
    data = b64encode(picture.png).decode("ascii")
    return (
        f'<figure><img alt="{escape(picture.title)}. {escape(picture.words)}" src="data:image/png;base64,{data}">'
        f"<figcaption>{escape(picture.title)}. {escape(picture.words)}</figcaption></figure>"
    )
