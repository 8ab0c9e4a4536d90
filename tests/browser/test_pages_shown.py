"""Our own pages in a real browser: no server is needed, each is complete in itself."""

import pytest

from gnsslab.teaching.pages.pages import data_page, glossary_page, home_page, lost_page, notation_page
from gnsslab.teaching.progress import Progress

PAGES = {
    "home": home_page,
    "notation": notation_page,
    "glossary": glossary_page,
    "data": data_page,
    "lost": lambda: lost_page("/a/long/way/" + 40 * "down"),
}


@pytest.fixture
def show(chromium):
    """A function that shows the text of a page; no console error may stand in the page's records when the test ends."""
    contexts, troubles = [], []

    def open_page(text, width=1280, scheme="light"):
        contexts.append(chromium.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme))
        page = contexts[-1].new_page()
        page.on("console", lambda message: troubles.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: troubles.append(str(error)))
        page.on("request", lambda request: troubles.append(request.url) if not request.url.startswith("data:") else None)
        page.set_content(text)
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert not troubles


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1280])
@pytest.mark.parametrize("name", PAGES)
def test_page_fits_and_follows_the_system(show, name, width, scheme):
    page = show(PAGES[name](), width, scheme)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    red = page.evaluate("getComputedStyle(document.body).backgroundColor.match(/\\d+/)[0]")
    assert (int(red) < 60) == (scheme == "dark")


@pytest.mark.parametrize("typed", ["baseline", "BASELINE", "\u57fa\u7ebf", "jixian", "ji xian", "j\u012bxi\u00e0n"])
def test_words_are_found_in_any_way_of_writing(show, typed):
    page = show(glossary_page())
    page.get_by_label("Find").fill(typed)
    assert page.locator("#baseline").is_visible()
    assert page.locator("#zero-baseline").is_visible()
    assert not page.locator("#accelerometer").is_visible()
    assert not page.locator("#letter-A").is_visible()
    assert page.locator(".filter [role=status]").inner_text().endswith("words")


def test_nothing_found_is_said_and_all_comes_back(show):
    page = show(glossary_page())
    page.get_by_label("Find").fill("no such thing")
    assert page.get_by_text("no such word").is_visible()
    page.get_by_label("Find").fill("")
    assert page.locator("#accelerometer").is_visible()
    assert page.get_by_role("link", name="Z", exact=True).is_visible()


def test_reset_is_two_steps_and_keys_suffice(show):
    progress = Progress()
    progress.record("00", "prediction", "prediction", "x", False)
    page = show(home_page(progress))
    button = page.get_by_role("button", name="Yes, begin anew")
    assert not button.is_visible()
    page.locator("summary").focus()
    page.keyboard.press("Enter")
    assert button.is_visible()
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.textContent") == "Yes, begin anew"


def test_first_stop_of_the_keyboard_leads_past_the_menu(show):
    page = show(notation_page())
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.getAttribute('href')") == "#content"
    assert page.get_by_role("link", name="Skip to the content").bounding_box()["x"] >= 0
