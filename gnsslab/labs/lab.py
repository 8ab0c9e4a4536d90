"""A lab: one interactive experiment as data and functions, with no front end in sight.

controls -> compute(**controls) -> frozen result -> figure(result), readouts(result)
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from gnsslab.labs.controls import Control


@dataclass(frozen=True)
class Readout:
    """One number beside the picture, ready to read aloud."""

    label: str
    value: str
    unit: str = ""
    note: str = ""  # a few words below the number


@dataclass(frozen=True)
class Preset:
    """Several controls set at once, with one sentence that says what to look at."""

    name: str
    label: str
    settings: Mapping[str, object]
    look_at: str


@dataclass(frozen=True)
class Drawing:
    """One picture of a lab: `build(figure)` lays out the axes and returns the function that shows a result in them."""

    name: str
    build: Callable
    width: int  # [CSS px]
    height: int  # [CSS px]
    presented: bool = False  # in front of a class the first is shown, and beside it those without which it is no use


@dataclass(frozen=True)
class Goal:
    """Something to reach with the controls; `judge(settings, result)` returns whether it is reached and where you stand."""

    name: str
    text: str
    judge: Callable


def standing(numbers, by_rule):
    """Return what a goal says of where you stand.

    >>> standing("97 % fixed", by_rule=False)
    'Now: 97 % fixed, but the controls are outside the rules.'
    """
    return f"Now: {numbers}." if by_rule else f"Now: {numbers}, but the controls are outside the rules."


def _nothing_blocked(settings):
    return {}


@dataclass(frozen=True, eq=False)
class Lab:
    """Controls, presets and the functions that turn settings into pictures and numbers."""

    name: str
    title: str
    controls: tuple[Control, ...]
    compute: Callable  # compute(**settings) -> frozen result, which carries `problem`: a sentence, or "" where all is well
    figure: Callable  # figure(result) -> matplotlib Figure with everything in it, for saving
    drawings: Callable  # drawings() -> tuple of Drawing, for front ends that keep their pictures
    describe: Callable  # describe(result) -> the pictures in words
    readouts: Callable  # readouts(result) -> list of Readout
    table: Callable  # table(result) -> {column with its unit, "heading_deg": (T,) values}, what is in the picture, for saving
    presets: tuple[Preset, ...] = ()
    goals: tuple[Goal, ...] = ()
    steering: tuple[str, ...] = ()  # names of the controls that decide which others have an effect
    blocked: Callable = field(default=_nothing_blocked)  # blocked(settings) -> {control name: why it has no effect now}

    @property
    def defaults(self):
        """Every control's default, by name."""
        return {control.name: control.default for control in self.controls}

    def control(self, name):
        """Return the control of that name."""
        return self._named("control", self.controls, name)

    def settings(self, **given):
        """Return all settings, the given ones checked, the others at their defaults."""
        return self.defaults | {name: self.control(name).check(value) for name, value in given.items()}

    def run(self, **given):
        """Return the result at the given settings; a value out of range raises ValueError in words."""
        return self.compute(**self.settings(**given))

    def preset(self, name):
        """Return the preset of that name."""
        return self._named("preset", self.presets, name)

    def goal(self, name):
        """Return the goal of that name."""
        return self._named("goal", self.goals, name)

    def _named(self, kind, records, name):
        found = [record for record in records if record.name == name]
        if not found:
            raise ValueError(f"lab {self.name} has no {kind} {name!r}: it has {', '.join(record.name for record in records)}")
        return found[0]
