"""One process that serves: it warms up every lab, and no two threads parse at once."""

import ast
import threading

from gnsslab.labs.lab import Lab
from gnsslab.teaching.server import serving


def test_every_lab_is_warmed_up(monkeypatch):
    warmed, run = [], Lab.run
    monkeypatch.setattr(Lab, "run", lambda lab, **given: warmed.append(lab.name) or run(lab, **given))
    serving.warm_up()
    assert warmed == [name for lesson in serving.LESSONS for name in lesson.open_labs()]
    assert warmed


def test_one_thread_at_a_time_parses_and_gets_its_own_tree(monkeypatch):
    inside, most = [], []

    def parse(source):
        inside.append(source)
        most.append(len(inside))
        tree = whole(source)
        inside.remove(source)
        return tree

    whole = ast.parse
    monkeypatch.setattr(ast, "parse", parse)
    serving.parse_one_at_a_time()
    found = {}
    threads = [threading.Thread(target=lambda n=n: found.update({n: ast.unparse(ast.parse(f"f({n})"))})) for n in range(50)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == {n: f"f({n})" for n in range(50)}
    assert set(most) == {1}


def test_the_guard_is_set_once(monkeypatch):
    monkeypatch.setattr(ast, "parse", ast.parse)
    serving.parse_one_at_a_time()
    guarded = ast.parse
    serving.parse_one_at_a_time()
    assert ast.parse is guarded
