"""One thing ahead: the same things, the same errors, in the same order."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from pytracker.evidence.ahead import ahead


def test_all_comes_in_order_whatever_it_is() -> None:
    given: list[object] = [0, None, [], "", 4]
    assert list(ahead(given)) == given
    assert list(ahead([])) == []


def test_what_a_source_raises_comes_after_what_it_gave() -> None:
    def source() -> Iterator[int]:
        yield 1
        yield 2
        raise ValueError("damaged")

    coming = ahead(source())
    assert [next(coming), next(coming)] == [1, 2]
    with pytest.raises(ValueError, match="damaged"):
        next(coming)


def test_it_is_one_ahead_and_no_more_and_ends_with_whoever_asks() -> None:
    made: list[int] = []
    second = threading.Event()

    def source() -> Iterator[int]:
        for k in range(10):
            made.append(k)
            if k == 1:
                second.set()
            yield k

    coming = ahead(source())
    assert next(coming) == 0
    assert second.wait(10.0)
    coming.close()
    assert made == [0, 1]
