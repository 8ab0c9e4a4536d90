"""Links that bring back a lab: all its controls and the seed in an address's query, `lab=north&length=2.5&seed=3`."""

from urllib.parse import urlencode

from gnsslab.labs.controls import FileOrPath


def query_of(lab, settings):
    """Return the query that brings back the settings; files of the student's own are left out: they are not in an address."""
    sent = {control.name: settings[control.name] for control in _linkable(lab)}
    return urlencode({"lab": lab.name} | {name: f"{value:g}" if isinstance(value, float) else value for name, value in sent.items()})


def settings_of(lab, query):
    """Return the settings that a query {name: text} gives, and a sentence for each that cannot be; what is not of this lab is left alone."""
    settings, problems = {}, []
    for control in _linkable(lab):
        if control.name in query:
            try:
                settings[control.name] = control.parse(query[control.name])
            except ValueError as refusal:
                problems.append(f"{refusal}: the link's value is left out.")
    return settings, problems


def preset_of(lab, query):
    """Return the preset of this lab that a query names, or None."""
    return next((preset for preset in lab.presets if preset.name == query.get("preset")), None)


def _linkable(lab):
    return [control for control in lab.controls if not isinstance(control, FileOrPath)]
