"""Each part is charged its own time, and the functions are as before afterwards."""

import time

import pytest

from plugins.stopwatch import Stopwatch


def busy(seconds):
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass


class Work:
    def outer(self):
        busy(0.02)
        self.inner()
        busy(0.02)

    def inner(self):
        busy(0.06)


def test_a_part_is_not_charged_for_the_parts_it_calls():
    before = Work.__dict__["outer"]
    with Stopwatch().over({"outer": [(Work, "outer")], "inner": [(Work, "inner")]}) as watch:
        Work().outer()
        busy(0.03)
    assert watch.seconds == pytest.approx({"outer": 0.04, "inner": 0.06, "rest": 0.03}, rel=0.2)
    assert Work.__dict__["outer"] is before


def test_a_failure_leaves_the_functions_as_they_were():
    before = Work.__dict__["inner"]
    with pytest.raises(ZeroDivisionError), Stopwatch().over({"inner": [(Work, "inner")]}):
        Work().inner()
        raise ZeroDivisionError
    assert Work.__dict__["inner"] is before
