"""What those are told who are not let in: small pages, each with the reason and what to do."""

from html import escape

from gnsslab.teaching.pages.pages import plain_page


def ask_for_token(query):
    """Return the page that asks for the token of the class; `query` is what else the address asked for."""
    return _door("This course is open to a class. Type its token: it stands in the link that you were given.", query)


def wrong_token(query):
    """Return the same page, which says that the token was wrong."""
    return _door("That token is not the one of this class. Look at it again and type it once more, with or without the hyphen.", query)


def foreign_host(host):
    """Return the page for a caller who reached a local course under another machine's name."""
    return _refusal(
        "This course is for its own machine",
        f"It was called as <code>{escape(host)}</code>. Open it as <code>localhost</code> or <code>127.0.0.1</code>. "
        "To serve a class, start it with <code>gnsslab course --host 0.0.0.0</code>.",
    )


def foreign_site(origin):
    """Return the page for what another site's page sent."""
    return _refusal(
        "This came from another site",
        f"A page of <code>{escape(origin)}</code> sent it, and the course listens to its own pages only. Open the course itself and try again.",
    )


def too_large(length, at_most):
    """Return the page for an upload that is too large."""
    return _refusal(
        "This file is too large for a class",
        f"{length / 1e6:.0f} MB came, at most {at_most / 1e6:.0f} MB are taken in one piece. "
        "Upload fewer epochs, or open the file in a course on your own machine.",
    )


def unknown_length():
    """Return the page for an upload that does not say how large it is."""
    return _refusal("This has no length", "Whatever is sent to the course must say how large it is. Browsers do.")


def _refusal(title, words, more=""):
    return plain_page(title, f'<div class="opening"><h1>{title}</h1><p class="lead">{words}</p>{more}</div>')


def _door(words, query):
    others = "".join(f'<input type="hidden" name="{escape(name)}" value="{escape(value)}">' for name, value in query.multi_items() if name != "token")
    field = '<input id="token" name="token" autocomplete="off" autocapitalize="none" spellcheck="false" autofocus required>'
    form = f'<form>{others}<label for="token">Token</label> {field} <button class="button">Open</button></form>'
    return _refusal("Which class?", words, form)
