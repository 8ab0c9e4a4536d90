"""Pages of the course, and what belongs to one lab on a lesson's page."""

import time


def stage(page, lab):
    """Return the parts of the page that belong to one lab."""
    return page.locator(f'.gl-stage[data-lab="{lab}"]')


def shown(page, lab):
    """Return readouts, problem and pictures of a lab, all of one moment."""
    parts = ", ".join(f'.gl-stage[data-lab="{lab}"] .gl-{part}' for part in ("readouts", "problem", "pictures img"))
    return page.evaluate("parts => [...document.querySelectorAll(parts)].map(part => part.src ?? part.innerText).join(' ')", parts)


def readouts(page, lab):
    """Return a lab's numbers, as one text."""
    return stage(page, lab).locator(".gl-readouts").inner_text()


def await_change(page, lab, before, patience):
    """Return a lab's numbers once they differ from those before; fail after so many milliseconds."""
    deadline = time.monotonic() + patience / 1000
    while readouts(page, lab) == before:
        assert time.monotonic() < deadline, "nothing changed"
        page.wait_for_timeout(20)
    return readouts(page, lab)


class Visitor:
    """Opens addresses of a course, each in a browser context of its own, and notes what goes wrong in their pages."""

    def __init__(self, browser, course):
        self.browser = browser
        self.course = course
        self.contexts = []
        self.troubles = []  # console errors, and requests that left the machine

    def open(self, path="/", width=1280, height=900, scheme="light"):
        """Return the page of an address, in a fresh context."""
        context = self.browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
        self.contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: self._note(f"console: {message.text}") if message.type == "error" else None)
        page.on("pageerror", lambda error: self._note(f"page error: {error}"))
        page.on("request", lambda request: self._note(f"left the machine: {request.url}") if self._is_foreign(request.url) else None)
        page.goto(self.course.rstrip("/") + path)
        return page

    def leave(self):
        """Close all pages."""
        for context in self.contexts:
            context.close()

    def _note(self, trouble):
        self.troubles.append(trouble)

    def _is_foreign(self, url):
        return not url.startswith((self.course, self.course.replace("http:", "ws:"), "data:", "blob:"))


class SharedLesson:
    """A lesson's page that the tests of a file share: one that moved a lab does not show in the next."""

    def __init__(self, page, lesson):
        self.page = page
        self.labs = lesson.open_labs()
        self.at_first = {lab: shown(page, lab) for lab in self.labs}

    def restored(self, patience):
        """Return the page with every lab as it was at first: one that shows something else is set by its first preset, all defaults."""
        for name, lab in self.labs.items():
            if shown(self.page, name) != self.at_first[name]:
                start = lab.presets[0]
                self.page.locator(f'.gl-preset[data-preset="{start.name}"]').get_by_role("button").click()
                stage(self.page, name).locator(f'.gl-look[data-preset="{start.name}"]').wait_for(timeout=patience)
                self.at_first[name] = shown(self.page, name)
        return self.page
