"""Which worker serves which browser."""

from collections import Counter

import pytest
from small_browser import SmallBrowser
from starlette.responses import PlainTextResponse

from gnsslab.teaching.server.seats import Seat, Usher, seat_number
from gnsslab.teaching.visitor import BROWSER_COOKIE, browser_of, new_browser


@pytest.mark.parametrize("of", [1, 2, 3, 8])
def test_a_worker_names_browsers_that_belong_to_it(of):
    for number in range(of):
        browser = Seat(number, of).new_browser()
        assert browser_of({BROWSER_COOKIE: browser}) == browser
        assert [seat for seat in range(of) if Seat(seat, of).is_of(browser)] == [number]


def test_ids_of_another_day_are_spread_over_all_workers():
    counts = Counter(seat_number(new_browser(), 4) for _ in range(4000))
    assert set(counts) == {0, 1, 2, 3}
    assert all(abs(count - 1000) < 4 * (4000 * 0.25 * 0.75) ** 0.5 for count in counts.values())  # 4 sigma of a count


def test_the_usher_sends_browsers_of_other_workers_to_ask_again():
    browser = SmallBrowser(Usher(PlainTextResponse("within"), Seat(0, 2)), "http://192.168.1.5:8000")
    assert browser.get("/lesson/00/").text == "within"
    browser.cookies[BROWSER_COOKIE] = Seat(0, 2).new_browser()
    assert browser.get("/lesson/00/").text == "within"
    browser.cookies[BROWSER_COOKIE] = Seat(1, 2).new_browser()
    answer = browser.post("/lesson/00/api?x=1")
    assert (answer.status, answer.headers["connection"]) == (307, "close")
    assert answer.headers["location"] == "http://192.168.1.5:8000/lesson/00/api?x=1"
