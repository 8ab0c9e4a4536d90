"""The controls of a lab as ipywidgets: each with its unit and help, or with the reason why it has no effect now."""

from decimal import Decimal

from ipywidgets import HTML, Checkbox, Dropdown, FileUpload, FloatSlider, HBox, IntSlider, Label, Layout, RadioButtons, Text, VBox

from gnsslab.labs.controls import Choice, FileOrPath, Slider, Switch
from gnsslab.teaching import markup

RADIO_AT_MOST = 3  # options that stand side by side; more go into a list


def shown_control(control, desk, moved):
    """Return a control on the screen; `moved(name, value)` is called whenever the student changes it."""
    return _KINDS[type(control)](control, desk, moved)


class ShownControl:
    """One control on the screen: the widget that holds its value, and below it the help."""

    def __init__(self, control, desk, moved):
        self.control = control
        self._desk = desk
        self._moved = moved
        self.widget = self._made()
        self._help = HTML()
        self.box = VBox([*self._parts(), self._help]).add_class("gl-control")
        self.show()
        self.widget.observe(self._tell, "value")

    @property
    def value(self):
        """What the lab gets."""
        return self.widget.value

    def show(self):
        """Show what stands on the desk: the value, and whether the control has an effect there."""
        self.widget.value = self._desk.settings[self.control.name]
        self._show_reason()

    def _show_reason(self):
        reason = self._desk.blocked.get(self.control.name, "")
        self.widget.disabled = bool(reason)
        self._help.value = markup.control_help(self.control, reason)

    def _tell(self, change):
        self._moved(self.control.name, self.value)

    def _parts(self):
        return [self.widget]

    def _described(self, text):
        """Return what all widgets take: their label, as long as it needs to be."""
        return {"description": text, "style": {"description_width": "initial"}, "layout": Layout(width="auto")}


class ShownSlider(ShownControl):
    """A slider; whole numbers where all of it is whole."""

    @property
    def value(self):
        """The number as it reads: the browser's steps carry rounding errors, also past the ends."""
        return round(self.widget.value, self._decimals) if self._decimals else self.widget.value

    def _made(self):
        control, decimals = self.control, self._decimals
        kind, numbers = (FloatSlider, f".{decimals}f") if decimals else (IntSlider, "d")
        label = self._described(f"{control.label} [{control.unit}]" if control.unit else control.label)
        return kind(control.default, min=control.start, max=control.stop, step=control.step, readout_format=numbers, **label)

    @property
    def _decimals(self):
        """Decimals of the finest of its numbers."""
        return max(-Decimal(str(number)).normalize().as_tuple().exponent for number in (self.control.step, self.control.start, 1))


class ShownChoice(ShownControl):
    """A few options in sight, more of them in a list."""

    def _made(self):
        options, label = list(self.control.options.items()), self._described(self.control.label)
        if len(options) > RADIO_AT_MOST:
            return Dropdown(options=options, value=self.control.default, **label)
        return RadioButtons(options=options, value=self.control.default, orientation="horizontal", **label)


class ShownSwitch(ShownControl):
    """A box to tick."""

    def _made(self):
        return Checkbox(self.control.default, indent=False, **self._described(self.control.label))


class ShownFile(ShownControl):
    """A file of the student's own, uploaded or named by its path; out of sight where it has no effect."""

    @property
    def value(self):
        """The path of the file."""
        return self._desk.given_file(self.control.name, self.widget.value.strip())

    def show(self):
        """Show the control where it has an effect; what was given stays."""
        self.box.layout.display = "none" if self.control.name in self._desk.blocked else ""
        self._show_reason()

    def _made(self):
        return Text(placeholder="its path", continuous_update=False, **self._described(self.control.label))

    def _parts(self):
        self._upload = FileUpload(description="Upload it")
        self._upload.observe(self._uploaded, "value")
        self._name = Label()
        return [self.widget, HBox([self._upload, self._name])]

    def _uploaded(self, change):
        file = change.new[-1]
        self._desk.given_file(self.control.name, "", (file.name, bytes(file.content)))
        self._name.value = f"{self._desk.uploaded_name(self.control.name)} is kept"
        self.widget.value = ""
        self._tell(change)


_KINDS = {Slider: ShownSlider, Choice: ShownChoice, Switch: ShownSwitch, FileOrPath: ShownFile}
