"""What belongs to one lab on a lesson's page."""

import time


def stage(page, lab):
    """Return the parts of the page that belong to one lab."""
    return page.locator(f'.gl-stage[data-lab="{lab}"]')


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
