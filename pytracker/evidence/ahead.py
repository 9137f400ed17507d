"""One thing ahead of whoever asks: decoding and OpenCV let the interpreter go."""

from __future__ import annotations

import itertools
from collections.abc import Generator, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

__all__ = ["ahead"]

T = TypeVar("T")


def ahead(source: Iterable[T]) -> Generator[T]:
    """The same in the same order; the next is worked out in a thread of its own.

    What `source` raises comes in its turn.
    """
    coming = iter(source)

    def work() -> list[T]:
        # A list, as whatever a source gives may be falsy: empty at its end.
        return list(itertools.islice(coming, 1))

    with ThreadPoolExecutor(1) as pool:
        following = pool.submit(work)
        while found := following.result():
            following = pool.submit(work)
            yield found[0]
