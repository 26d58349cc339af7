"""Commands of `iridesce`, each in a process of its own that has its modules already.

A process that has imported what commands need waits for words, and forks one for each of them: exit codes, both streams, the
folder and the end of the interpreter are the real ones, and 0.4 s of imports are paid once. Whoever asks for the imports
themselves, or for an environment of their own, starts a new interpreter.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import gc
import json
import os
import runpy
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

# Words of a message: how long it is, the number of a process, an exit code.
WORD = 8


def number(value: int) -> bytes:
    """A number as a message."""
    return value.to_bytes(WORD, "little", signed=True)


def received(connection: socket.socket, count: int) -> bytes:
    """So many bytes; fewer where the other side has gone."""
    data = b""
    while len(data) < count and (part := connection.recv(count - len(data))):
        data += part
    return data


def environment() -> dict[str, str]:
    """What a process inherits, but for what pytest tells of its own course."""
    return {name: value for name, value in os.environ.items() if name != "PYTEST_CURRENT_TEST"}


class CommandLine:
    """Runs commands as a shell would: ``CommandLine().run(["color", "air / soap 320 / air"], folder).stdout``."""

    def __init__(self) -> None:
        self.server: subprocess.Popen[bytes] | None = None
        self.environment = environment()

    def is_current(self) -> bool:
        """Whether a command would find the environment that it would find in a new interpreter."""
        return environment() == self.environment

    def start(self) -> None:
        """The process that commands are forked from."""
        self.connection, theirs = socket.socketpair()
        with theirs:
            self.server = subprocess.Popen(
                [sys.executable, __file__, str(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                env={**os.environ, "COLUMNS": "120"},
            )

    def stop(self) -> None:
        """No more commands."""
        if self.server is not None:
            self.connection.close()
            self.server.wait(10.0)
            self.server = None

    def run(self, words: list[str], cwd: Path, timeout: float = 120.0) -> subprocess.CompletedProcess[str]:
        """A command to its end; ``TimeoutExpired`` beyond the time, as ``subprocess.run`` has it."""
        if self.server is None:
            self.start()
        with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as error:
            message = json.dumps([str(cwd), *words]).encode()
            socket.send_fds(self.connection, [number(len(message))], [out.fileno(), error.fileno()])
            self.connection.sendall(message)
            self.connection.settimeout(60.0)
            pid = int.from_bytes(received(self.connection, WORD), "little", signed=True)
            self.connection.settimeout(timeout)
            command = [sys.executable, "-m", "iridesce", *words]
            try:
                code = int.from_bytes(received(self.connection, WORD), "little", signed=True)
            except TimeoutError:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
                self.connection.settimeout(10.0)
                received(self.connection, WORD)
                raise subprocess.TimeoutExpired(command, timeout) from None
            texts = []
            for file in (out, error):
                file.seek(0)
                texts.append(file.read())
        return subprocess.CompletedProcess(command, code, *texts)


@functools.cache
def shared() -> CommandLine:
    """The one of this process, which ends with it."""
    commands = CommandLine()
    atexit.register(commands.stop)
    return commands


def run(
    words: Sequence[str], cwd: Path, env: Mapping[str, str] | None = None, timeout: float = 300.0
) -> subprocess.CompletedProcess[str]:
    """A command to its end. With an environment, or where this process's own has changed, in a new interpreter."""
    if hasattr(os, "fork") and env is None and shared().is_current():
        return shared().run(list(words), cwd, timeout)
    return subprocess.run(
        [sys.executable, "-m", "iridesce", *words],
        cwd=cwd,
        env={**os.environ, "COLUMNS": "120", **(env or {})},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )


def serve(connection: socket.socket) -> list[str] | None:
    """Forks a process for each command. There: its words, with streams and folder in place; here, at the end, nothing."""
    while True:
        head, streams, _, _ = socket.recv_fds(connection, WORD, 2)
        if not head:
            return None
        cwd, *words = json.loads(received(connection, int.from_bytes(head, "little")))
        if (pid := os.fork()) == 0:
            connection.close()
            for place, stream in zip((1, 2), streams, strict=True):
                os.dup2(stream, place)
                os.close(stream)
            os.chdir(cwd)
            return words
        for stream in streams:
            os.close(stream)
        connection.sendall(number(pid))
        connection.sendall(number(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])))


def main() -> None:
    """Imports what commands import, and serves."""
    import matplotlib.backends.backend_agg
    import matplotlib.figure  # noqa: F401

    import iridesce
    from iridesce.cli.entry import application

    application()
    for name in iridesce.__all__:
        getattr(iridesce, name)
    del sys.path[0]  # this folder: of a command it is none
    # A command that ends looks through all that was ever imported for cycles, and copies every page of it that it shares with
    # this process: 0.2 s each. What a command makes itself is looked through as ever.
    gc.collect()
    gc.freeze()
    words = serve(socket.socket(fileno=int(sys.argv[1])))
    if words is not None:
        sys.argv = ["iridesce", *words]
        runpy.run_module("iridesce", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
