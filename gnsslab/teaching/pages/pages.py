"""The pages around the lessons, each complete in itself: no script, picture or font from elsewhere."""

from html import escape
from pathlib import Path
from string import Template

from gnsslab import __version__
from gnsslab.teaching.pages.glossary import glossary_body
from gnsslab.teaching.pages.home import home_body
from gnsslab.teaching.pages.notation import notation_body

HERE = Path(__file__).parent
PAGES = {"/": "Lessons", "/notation": "Notation", "/glossary": "Glossary", "/data": "Data"}


def home_page(progress=None, present=False):
    """Return the home page: the lessons, and how far the student is in each; `present` opens them for a class."""
    return _page("/", "gnsslab: precise GNSS by hand", home_body(progress, present))


def notation_page():
    """Return the page of symbols; each has an id to link to: /notation#sigma_phi."""
    return _page("/notation", "Notation", notation_body())


def data_page():
    """Return the page that says where the measurements come from and whose they are."""
    from gnsslab.teaching.pages.data_sources import data_body  # loads numpy, which no other page needs

    return _page("/data", "Data", data_body())


def glossary_page():
    """Return the glossary, English and Chinese."""
    return _page("/glossary", "Glossary", glossary_body())


def lost_page(path):
    """Return what an unknown address gets: the way home."""
    body = (
        '<div class="opening"><h1>There is nothing here</h1>'
        f'<p class="lead">The course has no page <code>{escape(path)}</code>. Perhaps the address was cut off or mistyped.</p>'
        '<p><a class="button" href="/">To the lessons</a></p></div>'
    )
    return _page("", "Nothing here", body)


def plain_page(title, body):
    """Return a page that is none of the course's own: what somebody is told who is not let in."""
    return _page("", title, body)


def _page(address, title, body):
    template = Template((HERE / "page.html").read_text("utf-8"))
    style = (HERE / "pages.css").read_text("utf-8")
    links = "".join(f'<a href="{to}"{_here(to == address)}>{name}</a>' for to, name in PAGES.items())
    return template.substitute(title=escape(title), style=style, links=links, body=body, version=__version__, home_is_here=_here(address == "/"))


def _here(is_here):
    return ' aria-current="page"' if is_here else ""
