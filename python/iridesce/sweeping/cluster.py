"""A sweep on the workers of a `dask.distributed` scheduler. Who runs where, and what is moved, is Dask's business; here is
what is asked of it, and what is done where workers or the scheduler die.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import pickle
import queue
import re
import time
import uuid
import warnings
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from iridesce import _core
from iridesce.arguments.refusals import Words, complaint, refusal
from iridesce.errors import ArgumentError
from iridesce.sweeping.needed import check_names, content, digests
from iridesce.sweeping.points import Made, Task
from iridesce.sweeping.store import Entry, Store, read_value
from iridesce.sweeping.subjects import Subject
from iridesce.sweeping.worker import PROBE, CannotLoad, CannotWrite, WrongWorker, call, carry, make_point

# How long a scheduler may take to answer: at first, and later on, when it may be busy.
CONNECT_S = 10.0
_ANSWER_S = 20.0
_LOOK_S = 2.0
_PATIENCE_S = 0.1
# Points that wait on the scheduler, for each thread of the workers: none of them idles while a result comes back.
_AHEAD = 3
# Dask gives a task up when four workers have died at it (`allowed-failures`). Such a point is then made again alone, so often.
_ROUNDS = 3


@contextlib.contextmanager
def opened(client: Any, function: Any = None, files: Sequence[str] = ()) -> Iterator[Cluster | None]:
    """The cluster that a caller means, closed again if it was opened here; None for this machine.

    client    None, an address, "local" or "local:N", a `distributed.Client`
    function  what is to be sent; refused before anything is opened if it cannot be
    files     names that workers will have to follow
    """
    if client is None:
        yield None
        return
    distributed = _distributed()
    check_names(files)
    if callable(function):
        _pickled(function)
    if isinstance(client, str):
        with _connected(distributed, client) as own:
            yield Cluster(own)
        return
    if not isinstance(client, distributed.Client):
        raise refusal("client", "None, an address or a dask.distributed Client", client)
    if client.asynchronous:
        raise refusal("client", "a synchronous dask.distributed Client", Words("an asynchronous one"))
    yield Cluster(client)


class Cluster:
    """Workers of one version and one SIMD level."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._address = client.scheduler.address if client.scheduler is not None else "?"
        self._looked = 0.0
        self._threads = 0
        self._told = False
        # Contents on their way to workers, by the key of the task that holds each.
        self._carried: dict[str, Any] = {}
        self._wait_for_workers()
        self.simd = self._level()

    @property
    def threads(self) -> int:
        """Threads of all workers, when they were last looked at."""
        return self._threads

    def make(
        self,
        subject: Subject,
        tasks: Sequence[Task],
        files: Mapping[str, Path],
        store: Store | None,
        threads: int | None,
    ) -> Iterator[Made]:
        """Make points, in the order in which they come back."""
        names = digests(files)
        # The folder of the caller says nothing to a worker, and must not make two subjects of one.
        blob = _pickled(subject.moved(Path()) if files else subject)
        wanted = (_core.__version__, self.simd)
        place = None if store is None else (str(store.folder.resolve()), store.id)

        def answer(task: Task, reply: tuple[Any, ...]) -> Made | None:
            return _received(task, reply, store)

        def failed(task: Task, message: str) -> Made:
            return _received(task, ("failed", message), store) or Made(task.number, None, message)

        with self._sent(blob, "subject") as base, contextlib.ExitStack() as stack:
            carried = {
                name: stack.enter_context(self._sent(content(path), "file", names[name]))
                for name, path in files.items()
            }

            def arguments(task: Task, is_second: bool) -> tuple[Any, ...]:
                return base, task.number, task.point, carried, names, None if is_second else place, threads, wanted

            yield from self._made(make_point, tasks, arguments, answer, failed)

    def ask(
        self,
        function: Callable[..., Any],
        common: Any,
        items: Sequence[tuple[Any, ...]],
        files: Mapping[str, Path] | None = None,
    ) -> Iterator[tuple[int, Any, Exception | None]]:
        """Call an importable function for each of some tuples: (place, answer, None) or (place, None, error) as they come.

        It is called as ``function(sent, *item)``, sent being a `Sent` of ``common`` and the files.
        """
        wanted = (_core.__version__, self.simd)
        names = digests(files or {})

        def answer(task: Task, reply: Any) -> Made:
            return Made(task.number, reply, None)

        with self._sent(_pickled(common), "subject") as blob, contextlib.ExitStack() as stack:
            carried = {
                name: stack.enter_context(self._sent(content(path), "file", names[name]))
                for name, path in (files or {}).items()
            }

            def arguments(task: Task, _: bool) -> tuple[Any, ...]:
                return function, wanted, blob, carried, names, items[task.number]

            tasks = [Task(number, {}) for number in range(len(items))]
            for number, reply, message in self._made(call, tasks, arguments, answer, _failed):
                yield (number, *reply) if message is None else (number, None, ConnectionError(message))

    def _made(
        self,
        function: Callable[..., Any],
        tasks: Sequence[Task],
        arguments: Callable[[Task, bool], tuple[Any, ...]],
        answer: Callable[[Task, Any], Made | None],
        failed: Callable[[Task, str], Made],
    ) -> Iterator[Made]:
        waiting = deque((task, False) for task in tasks)
        suspects: deque[Task] = deque()
        deaths: dict[int, int] = {}
        ready: queue.SimpleQueue[Any] = queue.SimpleQueue()
        running: dict[str, tuple[Task, Any]] = {}
        run = uuid.uuid4().hex[:12]
        count = 0

        def send(task: Task, is_second: bool) -> None:
            nonlocal count
            count += 1
            key = f"iridesce-{run}-{task.number}-{count}"
            future = self._submitted(function, *arguments(task, is_second), key=key)
            running[key] = (task, future)
            future.add_done_callback(ready.put)

        try:
            while waiting or running or suspects:
                while waiting and len(running) < max(_AHEAD * self._threads, 2):
                    send(*waiting.popleft())
                if not running and not waiting:
                    # Alone on the cluster: what its worker dies of now is the point itself.
                    send(suspects.popleft(), False)
                try:
                    future = ready.get(timeout=_PATIENCE_S)
                except queue.Empty:
                    future = None
                self._look()
                if future is None or future.key not in running:
                    continue
                task, _ = running[future.key]
                try:
                    reply = self._result(future)
                except _NotYet:
                    ready.put(future)
                    continue
                del running[future.key]
                if isinstance(reply, _Again):
                    waiting.appendleft((task, False))
                    continue
                if isinstance(reply, _Died):
                    deaths[task.number] = deaths.get(task.number, 0) + 1
                    if deaths[task.number] > _ROUNDS:
                        yield failed(task, f"its worker died each time ({reply.words})")
                    else:
                        suspects.append(task)
                    continue
                made = answer(task, reply)
                if made is None:
                    # The file that a worker says it wrote is not here: it is sent instead.
                    waiting.appendleft((task, True))
                else:
                    yield made
        finally:
            if running and self._client.status == "running":
                with contextlib.suppress(Exception):
                    self._client.cancel([future for _, future in running.values()], force=True)

    def _result(self, future: Any) -> Any:
        """What came of a task: its answer, `_Died` or `_Again`; errors that end the sweep are raised."""
        distributed = _distributed()
        try:
            return future.result(timeout=_ANSWER_S)
        except TimeoutError:
            raise _NotYet from None
        except WrongWorker as error:
            raise ValueError(f"{error}; start workers of one kind, or all with one IRIDESCE_SIMD") from None
        except CannotLoad as error:
            raise ValueError(f"a worker cannot load what it was sent: {error}") from None
        except CannotWrite as error:
            raise OSError(*error.args) from None
        except distributed.KilledWorker as error:
            if error.task != future.key:
                # What was blamed is a content that all points need: whichever worker held it died. No point's fault.
                self._carry_again(error.task)
                return _Again()
            return _Died("out of memory, or stopped from outside")
        except ModuleNotFoundError as error:
            package = (error.name or "").split(".")[0]
            raise ValueError(f'a worker has no package "{package}": install what the client has') from None
        except BaseException as error:
            if isinstance(error, KeyboardInterrupt | SystemExit):
                raise
            self._look(now=True)
            # Cancelled, lost with its worker, or torn on the way: made again.
            return _Died(f"{type(error).__name__}: {error}"[:200])

    def _submitted(self, function: Callable[..., Any], *arguments: Any, key: str) -> Any:
        try:
            return self._client.submit(function, *arguments, key=key, pure=False)
        except Exception as error:
            self._look(now=True)
            raise ConnectionError(f"the scheduler at {self._address} takes no more work: {error}") from None

    @contextlib.contextmanager
    def _sent(self, value: bytes, kind: str, digest: str | None = None) -> Iterator[Any]:
        """A content on its way to the workers that ask for it, once a cluster whatever sweeps need it."""
        key = f"iridesce-{kind}-{digest or hashlib.sha256(value).hexdigest()}"
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Sending large graph")
            future = self._submitted(carry, value, key=key)
        self._carried[key] = future
        try:
            yield future
        finally:
            self._carried.pop(key, None)

    def _carry_again(self, key: str) -> None:
        future = self._carried.get(key)
        if future is not None and future.status == "error":
            self._client.retry([future])

    def _look(self, now: bool = False) -> None:
        """Every other second: is the scheduler there, and how many threads do workers have?"""
        if self._client.status == "running" and not now and time.monotonic() - self._looked < _LOOK_S:
            return
        if self._client.status == "running":
            with contextlib.suppress(Exception):
                threads = self._client.sync(self._client.scheduler.ncores, workers=None, callback_timeout=_ANSWER_S)
                self._threads = sum(threads.values())
                self._looked = time.monotonic()
                return
        raise ConnectionError(
            f"the scheduler at {self._address} is gone; a store keeps what was made, and the same call goes on from there"
        )

    def _wait_for_workers(self) -> None:
        while True:
            self._look(now=True)
            if self._threads:
                return
            if not self._told:
                self._told = True
                warnings.warn(f"the scheduler at {self._address} has no workers yet; waiting for them", stacklevel=6)
            time.sleep(0.3)

    def _level(self) -> str:
        """The one SIMD level of all workers."""
        space: dict[str, Any] = {"__name__": "__main__"}
        exec(PROBE, space)
        for _ in range(10):
            try:
                answers = self._client.run(space["probe"], on_error="return")
            except Exception:
                self._look(now=True)
                time.sleep(0.5)
                continue
            answers = {where: one for where, one in answers.items() if isinstance(one, dict)}
            if answers:
                return _one_level(answers)
            time.sleep(0.5)
        raise ConnectionError(f"the workers of {self._address} do not answer")


class _Died(Exception):
    """A task that its worker's death, or the network, took away."""

    def __init__(self, words: str) -> None:
        super().__init__(words)
        self.words = words


class _Again(Exception):
    """A task that was taken away with what it needed."""


class _NotYet(Exception):
    """A result that is still on its way."""


def _failed(task: Task, message: str) -> Made:
    return Made(task.number, None, message)


def _received(task: Task, reply: tuple[Any, ...], store: Store | None) -> Made | None:
    """A worker's answer, kept; None where a file that it wrote is not to be seen here."""
    kind, *rest = reply
    if kind == "failed":
        if store is not None:
            store.put_failure(task.number, task.point, rest[0])
        return Made(task.number, None, rest[0])
    if kind == "there":
        assert store is not None
        entry = Entry(*rest)
        if not store.is_there(entry):
            return None
        store.record(task.number, entry)
        return Made(task.number, None, None)
    ending, inside = rest
    if store is None:
        return Made(task.number, read_value(ending, inside), None)
    store.put_content(task.number, ending, inside)
    return Made(task.number, None, None)


def _one_level(answers: Mapping[str, Mapping[str, str]]) -> str:
    """The level, or what keeps these workers from one sweep."""
    for where, one in answers.items():
        if "missing" in one:
            raise ValueError(f"the worker at {where} has no iridesce: {one['missing']}")
        if one["version"] != _core.__version__:
            raise ValueError(f"the worker at {where} has iridesce {one['version']}, this is {_core.__version__}")
    levels = sorted({one["simd"] for one in answers.values()})
    if len(levels) > 1:
        counts = ", ".join(f"{sum(o['simd'] == level for o in answers.values())} of {level}" for level in levels)
        raise ValueError(
            f"the workers have several SIMD levels, which give other last digits: {counts}; start all with "
            "IRIDESCE_SIMD set to one that each has"
        )
    return levels[0]


def _pickled(value: Any) -> bytes:
    import cloudpickle

    try:
        found: bytes = cloudpickle.dumps(value)
        pickle.loads(found)
    except Exception as error:
        words = f"quantity cannot be sent to workers: {type(error).__name__}: {error}"
        raise complaint(words, "quantity", "a function that can be sent to workers", value) from None
    return found


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise ImportError('a client needs Dask: pip install "iridesce[dask]"') from None
    return distributed


@contextlib.contextmanager
def _connected(distributed: Any, address: str) -> Iterator[Any]:
    """A client of our own for an address; or workers on this machine, which nothing outside it can reach."""
    own = re.fullmatch(r"local(?::(\d{1,4}))?", address)
    if own is not None:
        count = int(own[1]) if own[1] else _core.threads()
        if count < 1:
            raise refusal("client", '"local:N" with N >= 1', address)
        with warnings.catch_warnings():
            # (Where another program has the port that it would like for its own pages.)
            warnings.filterwarnings("ignore", message="Port .* is already in use")
            cluster = distributed.LocalCluster(
                n_workers=count,
                threads_per_worker=1,
                host="127.0.0.1",
                dashboard_address=None,
                silence_logs=logging.CRITICAL,
            )
        with cluster, distributed.Client(cluster, set_as_default=False) as client:
            yield client
        return
    _knock(address)
    try:
        client = distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
    except OSError:
        raise ConnectionError(_NOBODY.format(address, CONNECT_S)) from None
    try:
        yield client
    finally:
        with contextlib.suppress(Exception):
            client.close(timeout=3.0)


def _no_address(address: str, problem: ValueError) -> ArgumentError:
    allowed = 'an address such as "tcp://127.0.0.1:8786", or "local:N"'
    return complaint(f"client must be {allowed}, got {address!r:.80} ({problem})", "client", allowed, address)


_NOBODY = "no Dask scheduler answers at {} within {:g} s"


def _knock(address: str) -> None:
    """Whether a scheduler answers at all. (A `Client` that finds none waits for itself once more when the program ends.)"""
    import asyncio
    import threading

    from distributed.comm import connect
    from distributed.comm.addressing import parse_address

    try:
        parse_address(address if "://" in address else f"tcp://{address}")
    except ValueError as error:
        raise _no_address(address, error) from None
    found: list[BaseException | None] = []

    async def knock() -> None:
        comm = await connect(address, timeout=CONNECT_S)
        await comm.close()

    def run() -> None:
        try:
            asyncio.run(knock())
            found.append(None)
        except BaseException as error:
            found.append(error)

    # In a thread of its own, since that of a notebook has a loop already.
    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    until = time.monotonic() + CONNECT_S + 2.0
    while thread.is_alive() and time.monotonic() < until:
        thread.join(_PATIENCE_S)
    problem = found[0] if found else OSError()
    if isinstance(problem, ValueError):
        raise _no_address(address, problem) from None
    if problem is not None:
        raise ConnectionError(_NOBODY.format(address, CONNECT_S)) from None
