"""Runs spread over Dask workers: local processes, or whatever a scheduler's address stands for."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import dask
from distributed import Client, Future, LocalCluster, wait
from distributed.client import FuturesCancelledError

from scenarios.campaign.flying import Row, crashed, fly
from scenarios.campaign.variations import Variation
from scenarios.config import Scenario
from scenarios.errors import ScenarioError
from scenarios.interrupt import children_deaf_to_it

CONNECT_S = 20
LOOK_S = 2.0
GONE = "the scheduler is gone; what was flown is kept: go on with --resume"
AHEAD = 4
"""Runs handed out for each worker: enough that none waits, few enough that little is flown twice after a loss."""


class SchedulerLostError(ScenarioError):
    """The connection to the scheduler broke; what was flown is kept."""


@contextmanager
def client_of(workers: int, scheduler: str | None) -> Iterator[Client]:
    """A client of `workers` local processes, or of the scheduler at an address. ScenarioError when there is none."""
    settings = {"distributed.comm.timeouts.connect": CONNECT_S, "distributed.scheduler.allowed-failures": 2}
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with dask.config.set(settings):
        if scheduler is not None:
            try:
                client = Client(scheduler, timeout=CONNECT_S)
            except (OSError, ValueError) as error:
                raise ScenarioError(f"--scheduler {scheduler}: {error or 'no answer'}") from error
            with client:
                yield client
            return
        with _local_cluster(workers) as cluster, Client(cluster) as client:
            yield client


def _local_cluster(workers: int) -> LocalCluster:
    with children_deaf_to_it():
        return LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            memory_limit=0,
            silence_logs=logging.CRITICAL,
        )


def fly_all(
    client: Client,
    scenario: Scenario,
    variations: Sequence[Variation],
    done: Callable[[Row], None],
    check: Callable[[], None],
) -> None:
    """Fly all of them, in whatever order; `done` gets each row as it comes. SchedulerLostError when that is gone.

    `check` is called every few seconds at least, and may end it by raising.

    A run whose worker died is flown again by another; the one that takes three of them along is a row that says so.
    """
    waiting = list(reversed(variations))
    flying: dict[Future[Row], Variation] = {}
    while waiting or flying:
        while waiting and len(flying) < AHEAD * max(1, len(client.nthreads())):
            own = waiting.pop()
            flying[client.submit(fly, scenario, own, pure=False)] = own
        for future in _settled(client, list(flying), check):
            own = flying.pop(future)
            error = None if future.status == "finished" else future.exception()
            done(future.result() if error is None else crashed(own, f"{type(error).__name__}: {error}"))


def _settled(client: Client, futures: Sequence[Future[Row]], check: Callable[[], None]) -> list[Future[Row]]:
    """Those that ended; waits for one. SchedulerLostError as soon as nothing can end any more."""
    while True:
        check()
        try:
            ended: set[Future[Row]] = wait(futures, timeout=LOOK_S, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            ended = set()
        except FuturesCancelledError:
            raise SchedulerLostError(GONE) from None
        if client.status != "running" or any(future.status in ("cancelled", "lost") for future in futures):
            raise SchedulerLostError(GONE)
        if ended:
            return [future for future in futures if future in ended]
