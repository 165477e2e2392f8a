"""CPU time of the parts of a run, each by itself: parts are functions wrapped while the watch runs, and left alone
otherwise.

A part that calls another is not charged for it.
"""

import time
from contextlib import contextmanager
from functools import wraps


class Stopwatch:
    """Times functions by name. seconds : {part: CPU time of this thread}, "rest" what no part took."""

    def __init__(self):
        self.seconds = {}
        self.running = ["rest"]
        self.since = 0.0

    def switch(self, now):
        """Charge the part that ran up to now."""
        part = self.running[-1]
        self.seconds[part] = self.seconds.get(part, 0.0) + now - self.since
        self.since = now

    def timed(self, function, part):
        """The function, charged to a part."""

        @wraps(function)
        def call(*arguments, **options):
            self.switch(time.thread_time())
            self.running.append(part)
            try:
                return function(*arguments, **options)
            finally:
                self.switch(time.thread_time())
                self.running.pop()

        return call

    @contextmanager
    def over(self, parts):
        """Time while inside. parts : {part: [(class or module, name of its function)]}"""
        kept = [(owner, name, owner.__dict__[name]) for functions in parts.values() for owner, name in functions]
        try:
            for part, functions in parts.items():
                for owner, name in functions:
                    setattr(owner, name, self.timed(owner.__dict__[name], part))
            self.since = time.thread_time()
            yield self
            self.switch(time.thread_time())
        finally:
            for owner, name, function in kept:
                setattr(owner, name, function)
