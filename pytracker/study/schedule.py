"""Many runs: on the threads of this machine, or on the workers of a Dask cluster. Results come as they are done."""

from __future__ import annotations

import os
import queue
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from threading import Event

from pytracker._core import InputError
from pytracker.study.execute import Result, execute, execute_anywhere, failed, open_source
from pytracker.study.plan import Run

__all__ = ["on_dask", "on_threads"]

CONNECT_S = 15


def on_threads(runs: Sequence[Run], workers: int | None = None) -> Iterator[tuple[Run, Result]]:
    """On `workers` threads, as many as cores where not said. Runs of one recording share it, one after the other."""
    groups = _by_source(runs)
    done: queue.SimpleQueue[tuple[Run, Result]] = queue.SimpleQueue()
    stop = Event()

    def work(group: list[Run]) -> None:
        try:
            source = open_source(*group[0].source)
        except Exception as error:
            for run in group:
                done.put((run, failed(error)))
            return
        for run in group:
            if stop.is_set():
                return
            done.put((run, execute(run, source)))

    pool = ThreadPoolExecutor(workers or os.cpu_count() or 1)
    try:
        futures = [pool.submit(work, group) for group in groups]
        for _ in runs:
            yield done.get()
        wait(futures)
    finally:
        # Whoever leaves early waits for the runs in flight, not for all that were planned.
        stop.set()
        pool.shutdown(cancel_futures=True)


def on_dask(runs: Sequence[Run], address: str, fingerprint: Callable[[], str]) -> Iterator[tuple[Run, Result]]:
    """On the workers of the cluster at `address`, such as `tcp://host:8786`.

    A worker that dies loses its runs to the others. Raises `InputError` where the `distributed` extra is absent, nobody
    answers, or a worker has another build of this package, whose results would not be the same.
    """
    try:
        from distributed import Client, as_completed  # noqa: PLC0415
    except ImportError:
        raise InputError(
            "a Dask cluster needs dask.distributed, expected pytracker[distributed] to be installed"
        ) from None
    try:
        client = Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(f"--scheduler {address}: {error}, expected the address of a Dask scheduler") from None
    with client:
        ours = fingerprint()
        for worker, theirs in client.run(fingerprint).items():
            if theirs != ours:
                raise InputError(
                    f"worker {worker} has another build of pytracker or OpenCV, expected the same everywhere"
                )
        ordered = [run for group in _by_source(runs) for run in group]
        futures = {client.submit(execute_anywhere, r, key=f"pytracker-{r.key}", pure=False): r for r in ordered}
        for future in as_completed(futures, loop=client.loop):
            try:
                result = future.result()
            except Exception as error:  # too many workers died under it
                result = failed(error)
            yield futures[future], result


def _by_source(runs: Sequence[Run]) -> list[list[Run]]:
    """Runs that share a recording, together: it is made once for all of them."""
    groups: dict[object, list[Run]] = {}
    for run in runs:
        groups.setdefault(run.source, []).append(run)
    return list(groups.values())
