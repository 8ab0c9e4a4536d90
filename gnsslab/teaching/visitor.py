"""Whose answers a page shows: this machine's user on a local course; in a class each browser by itself, by a random id in a cookie.

A class is known by the folder it keeps its students' progress in; the variable that names it also reaches worker processes.
"""

import os
import secrets
from pathlib import Path

from gnsslab.teaching.progress import BROWSER_ID, Progress, own_progress, progress_folder, progress_of_browser

CLASS = "GNSSLAB_COURSE_SHARED"  # names the folder of the class; set where others than this machine's user are served
BROWSER_COOKIE = "gnsslab-browser"


def progress_of(request):
    """Return the progress of whoever made the request (Starlette's or marimo's; None outside a server).

    A visitor of a class whose browser keeps no cookies is remembered until the page is closed.
    """
    if not is_class():
        return own_progress()
    browser = None if request is None else browser_of(request.cookies)
    return Progress() if browser is None else progress_of_browser(class_folder(), browser)


def is_class():
    """Return whether others than this machine's user are served: they share nothing, and name no file of this machine."""
    return bool(os.environ.get(CLASS))


def open_class():
    """Serve a class from now on, in this process and those it starts; return the folder that keeps its progress."""
    folder = progress_folder() / "class"
    os.environ[CLASS] = str(folder)
    return folder


def class_folder():
    """Return the folder with the progress of this class, one file a browser."""
    return Path(os.environ[CLASS])


def browser_of(cookies):
    """Return the id of the browser that sent these cookies, or None where it has none (or one that is not ours)."""
    browser = cookies.get(BROWSER_COOKIE, "")
    return browser if BROWSER_ID.fullmatch(browser) else None


def new_browser():
    """Return an id for a browser: random, so that nobody guesses another's."""
    return secrets.token_hex(16)
