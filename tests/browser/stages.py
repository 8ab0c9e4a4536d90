"""What belongs to one lab on a lesson's page."""

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
