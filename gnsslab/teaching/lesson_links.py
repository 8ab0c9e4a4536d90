"""A lesson's number as a link, where the course has the lesson already."""

from html import escape

from gnsslab.teaching.catalogue import LESSONS


def lesson_link(number, words):
    """Return the words as a link to the lesson of that number; "" where the course has no such lesson (yet).

    >>> lesson_link("00", "lesson 00"), lesson_link("99", "lesson 99")
    ('<a href="/lesson/00/">lesson 00</a>', '')
    """
    addresses = [lesson.address for lesson in LESSONS if lesson.number == number]
    return f'<a href="{addresses[0]}">{escape(words)}</a>' if addresses else ""
