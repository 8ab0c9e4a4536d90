"""What the parts of a lesson in JupyterLab share: how a cell shows them, their Markdown, and errors without a traceback."""

import asyncio
from html import escape
from pathlib import Path

from ipywidgets import HTML, Output

from gnsslab.teaching import markup

_DARK = '[data-jp-theme-light="false"]'  # how JupyterLab marks its dark theme
STYLE = markup.STYLE.replace(".dark", _DARK) + (Path(__file__).parent / "widgets.css").read_text("utf-8")


class Shown:
    """Something that a cell displays: the widgets in `box`."""

    def _repr_mimebundle_(self, **how):
        return self.box._repr_mimebundle_(**how)


class Refusal(ValueError):
    """A bad call in a student's cell, which IPython shows as its sentence alone."""

    def _render_traceback_(self):
        return [str(self)]


class Markdown(Output):
    """Text with formulas, rendered by JupyterLab like that of a Markdown cell."""

    def __init__(self, text=""):
        super().__init__()
        self.say(text)

    def say(self, text):
        """Show another text; nothing for an empty one."""
        data = {"output_type": "display_data", "data": {"text/markdown": text}, "metadata": {}}
        self.outputs = (data,) if text else ()


def note(sentence, kind="gl-note"):
    """Return one sentence as a widget."""
    return HTML(f'<p class="{kind}" role="status">{escape(sentence)}</p>' if sentence else "")


def soon(work, seconds=0.0):
    """Call a function once what was sent before is on the screen; at once where no event loop runs, outside a kernel."""
    try:
        asyncio.get_running_loop().call_later(seconds, work)
    except RuntimeError:
        work()
