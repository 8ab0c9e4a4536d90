"""The whole course as one ASGI app: our own pages, each lesson as a marimo app, and the door before all of it."""

from contextlib import asynccontextmanager, chdir

import marimo
from starlette.applications import Starlette
from starlette.responses import HTMLResponse, RedirectResponse, Response
from starlette.routing import Mount, Route

from gnsslab.data.locations import project_folder
from gnsslab.teaching.catalogue import LESSONS
from gnsslab.teaching.pages import pages
from gnsslab.teaching.server.door import BrowserIds, Door, guards_of_class, guards_of_own_course
from gnsslab.teaching.visitor import is_class, new_browser, progress_of

STATIC = {"/notation": pages.notation_page, "/data": pages.data_page, "/glossary": pages.glossary_page}


def course_app(token="", present=False, new_id=new_browser):
    """Return the course as an ASGI app: "/" is the home page, "/lesson/NN/" a lesson.

    `token` opens a class ("": open to all); with `present` the home page leads to lessons as they are shown to a class;
    `new_id()` makes the id of a browser.
    """
    app = _site(present)
    return BrowserIds(Door(app, guards_of_class(token)), new_id) if is_class() else Door(app, guards_of_own_course())


def _site(present):
    lessons = _lesson_mounts()
    return Starlette(
        routes=[*_page_routes(present), *_progress_routes(), *map(_slashless, LESSONS), *lessons],
        exception_handlers={404: _lost, 405: _lost},
        lifespan=lambda _: _sessions_end_with(lessons),
    )


def _page_routes(present):
    def home(request):
        is_shown = present or request.query_params.get("mode") == "present"
        return HTMLResponse(pages.home_page(progress_of(request), is_shown), headers={"cache-control": "no-store"})

    return [Route("/", home), *(Route(path, _static(page)) for path, page in STATIC.items())]


def _static(page):
    return lambda request: HTMLResponse(page())


def _progress_routes():
    return [
        Route("/progress.json", lambda request: _download(progress_of(request).as_json(), "application/json", "json")),
        Route("/progress.csv", lambda request: _download(progress_of(request).as_csv(), "text/csv", "csv")),
        Route("/progress/reset", _reset, methods=["POST"]),
    ]


def _download(text, kind, ending):
    disposition = f'attachment; filename="gnsslab-progress.{ending}"'
    return Response(text, media_type=kind, headers={"content-disposition": disposition, "cache-control": "no-store"})


def _reset(request):
    progress_of(request).reset()
    return RedirectResponse("/", 303)


def _slashless(lesson):
    return Route(lesson.address.rstrip("/"), lambda request: RedirectResponse(request.url.replace(path=lesson.address)))


def _lost(request, error):
    return HTMLResponse(pages.lost_page(request.url.path), error.status_code)


def _lesson_mounts():
    """Return the lessons as routes. marimo would answer unknown addresses itself, in its own words: so its app is left out."""
    with chdir(project_folder("lessons")):  # where marimo looks for its display settings, once
        builder = marimo.create_asgi_app(quiet=True, include_code=False)
    for lesson in LESSONS:
        builder = builder.with_app(path=lesson.address.rstrip("/"), root=str(lesson.path))
    return [route for route in builder.build().routes if isinstance(route, Mount)]


@asynccontextmanager
async def _sessions_end_with(lessons):
    """End every open lesson when the server stops: mounted apps are not told of it, and their threads would keep the process alive."""
    yield
    for lesson in lessons:
        await lesson.app.state.session_manager.shutdown()
