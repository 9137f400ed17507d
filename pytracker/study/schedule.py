"""Many runs: on the threads of this machine, or on the workers of a Dask cluster. Results come as they are done."""

from __future__ import annotations

import os
import queue
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from threading import Event

from pytracker._core import InputError
from pytracker.study.execute import OTHER_BUILD, Result, Source, execute, execute_anywhere, failed, open_source
from pytracker.study.fingerprint import fingerprint
from pytracker.study.plan import Run

__all__ = ["on_dask", "on_threads"]

CONNECT_S = 15


def on_threads(
    runs: Sequence[Run], workers: int | None, scratch: Path, save: Callable[[Run, Result], None]
) -> Iterator[tuple[Run, Result]]:
    """On `workers` threads, as many as cores where not said. Runs of one recording share it, one after the other.

    Each result is saved where it is made: whoever leaves early keeps the runs that were in flight.
    """
    count = workers or os.cpu_count() or 1
    groups = _by_source(runs)
    if len(groups) < count:  # fewer recordings than threads: each is opened by several
        groups = [part for group in groups for k in range(count) if (part := group[k::count])]
    done: queue.SimpleQueue[tuple[Run, Result]] = queue.SimpleQueue()
    stop = Event()

    def work(group: list[Run]) -> None:
        try:
            recording, seed, _ = group[0].source
            source: Source | Result = open_source(recording, seed, scratch)
        except Exception as error:
            source = failed(error)
        for run in group:
            if stop.is_set():
                return
            result = source if isinstance(source, Result) else execute(run, source)
            save(run, result)
            done.put((run, result))

    pool = ThreadPoolExecutor(count)
    try:
        futures = [pool.submit(work, group) for group in groups]
        for _ in runs:
            yield _next(done, futures)
    finally:
        # Whoever leaves early waits for the runs in flight, not for all that were planned.
        stop.set()
        pool.shutdown(cancel_futures=True)


def _next(done: queue.SimpleQueue[tuple[Run, Result]], futures: Sequence[Future[None]]) -> tuple[Run, Result]:
    """The next result; what broke a thread, such as a full disk, is raised here."""
    while True:
        try:
            return done.get(timeout=1.0)
        except queue.Empty:
            for future in futures:
                if future.done() and not future.cancelled():
                    future.result()


def on_dask(runs: Sequence[Run], address: str, save: Callable[[Run, Result], None]) -> Iterator[tuple[Run, Result]]:
    """On the workers of the cluster at `address`, such as `tcp://host:8786`.

    A worker that dies loses its runs to the others. Raises `InputError` where the `distributed` extra is absent, nobody
    answers, or a worker has another build of this package, whose results would not be the same.
    """
    try:
        from distributed import Client, as_completed  # noqa: PLC0415 - an extra
    except ImportError:
        raise InputError("a Dask cluster needs dask.distributed: pip install distributed") from None
    if not address.startswith("tcp://"):
        raise InputError(f"--scheduler is {address!r}, expected the address of a Dask scheduler, tcp://HOST:PORT")
    try:
        client = Client(address, timeout=CONNECT_S, set_as_default=False)
    except Exception as error:
        raise InputError(f"--scheduler {address}: {error}, expected the address of a Dask scheduler") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECT_S)
        except TimeoutError:
            raise InputError(f"--scheduler {address}: has no worker for {CONNECT_S} s, expected one at least") from None
        ours = fingerprint()
        try:
            builds = client.run(fingerprint)
        except Exception as error:
            raise InputError(f"--scheduler {address}: a worker cannot run pytracker: {error}") from None
        for worker, theirs in builds.items():
            if theirs != ours:
                raise InputError(f"{worker}: {OTHER_BUILD}")
        ordered = [run for group in _by_source(runs) for run in group]
        futures = {client.submit(_on_worker, r, ours, key=f"pytracker-{r.key}", pure=False): r for r in ordered}
        for future in as_completed(futures, loop=client.loop):
            try:
                result = future.result()
            except Exception as error:  # too many workers died under it
                result = failed(error)
            save(futures[future], result)
            yield futures[future], result


def _on_worker(run: Run, expected: str) -> Result:
    """One run in the worker's own folder: Dask sweeps those of workers that died."""
    from distributed import get_worker  # noqa: PLC0415 - an extra

    return execute_anywhere(run, expected, Path(get_worker().local_directory))


def _by_source(runs: Sequence[Run]) -> list[list[Run]]:
    """Runs that share a recording, together: it is made once for all of them."""
    groups: dict[object, list[Run]] = {}
    for run in runs:
        groups.setdefault(run.source, []).append(run)
    return list(groups.values())
