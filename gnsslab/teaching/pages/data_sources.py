"""The data page's content: every real set with its origin, how to bring own files, and the law behind simulated ones."""

import re
from html import escape
from pathlib import Path
from string import Template

from gnsslab.data import read_registry
from gnsslab.data.locations import project_folder
from gnsslab.simulate.presets import PRESETS
from gnsslab.simulate.receivers import LOW_COST, SURVEY

_ORIGIN = re.compile(r"(https://github\.com/[^/]+/[^/]+)/raw/([0-9a-f]{40})/")

NOISE = {  # how each standard deviation of a preset's noise is told: (words, unit, how many of it make one SI unit)
    "code": ("code, white", "m", 1),
    "carrier": ("carrier phase, white", "mm", 1000),
    "doppler": ("Doppler as range rate, white", "m/s", 1),
    "code_multipath": ("code, multipath", "m", 1),
    "code_multipath_time": ("code, how long multipath lasts", "s", 1),
    "carrier_multipath": ("carrier phase, multipath", "mm", 1000),
    "carrier_multipath_time": ("carrier phase, how long multipath lasts", "s", 1),
    "cn0": ("carrier-to-noise density", "dB-Hz", 1),
}


def data_body():
    """Return the content of the data page."""
    template = Template(Path(__file__).with_name("data.html").read_text("utf-8"))
    return template.substitute(
        sets="".join(map(_real_set, read_registry().values())),
        noise=_noise_table(),
        presets="".join(map(_preset, PRESETS.values())),
    )


def _real_set(dataset):
    """Return one real set with its facts."""
    facts = {
        "Where": dataset.place,
        "When": dataset.span,
        "Receivers": dataset.receivers,
        "Known answer": dataset.truth,
        "Used for": dataset.use,
        "Licence": dataset.licence,
        "Credit": dataset.credit,
    }
    rows = "".join(f"<div><dt>{name}</dt><dd>{escape(fact)}</dd></div>" for name, fact in facts.items())
    return (
        f'<section class="set" id="{dataset.name}"><h3>{escape(dataset.title)}</h3><p class="meta"><code>{dataset.name}</code></p>'
        f"<dl>{rows}<div><dt>How it comes</dt><dd>{_way_here(dataset)}</dd></div></dl></section>"
    )


def _way_here(dataset):
    """Return how a set is had: it travels along, is downloaded, or was made from what is downloaded."""
    size = f"{dataset.size / 1e6:.1f} MB"
    origin = next(_ORIGIN.match(file.url) for file in dataset.files if file.url)
    link = f'<a href="{origin[1]}/tree/{origin[2]}">{origin[1].removeprefix("https://")}</a>'
    if (project_folder("datasets") / dataset.name).is_dir():
        return f"travels with the course, packed ({size} unpacked); from {link}"
    made = [file for file in dataset.files if file.made_from]
    rest = f"; {len(made)} of its {len(dataset.files)} files were {escape(made[0].made_from)} and come from a local mirror only" if made else ""
    return f"downloaded when first used ({size}), from {link} at a fixed commit{rest}"


def _noise_table():
    rows = "".join(
        f'<tr><th scope="row">{words}</th><td>{getattr(SURVEY, name) * scale:g}</td><td>{getattr(LOW_COST, name) * scale:g}</td><td>{unit}</td></tr>'
        for name, (words, unit, scale) in NOISE.items()
    )
    head = '<tr><th scope="col">Error</th><th scope="col">Survey receiver</th><th scope="col">Low-cost receiver</th><th scope="col">Unit</th></tr>'
    return f'<table class="noise"><thead>{head}</thead><tbody>{rows}</tbody></table>'


def _preset(preset):
    return f"<div><dt>{escape(preset.title)} <code>{preset.name}</code></dt><dd>{escape(preset.sentence)}</dd></div>"
