# SPDX-License-Identifier: Apache-2.0
"""Runs the README line by line on a Debian without other packages; then, each on its own Debian, the container file of
docs/ci and the first command of CONTRIBUTING.md. These two run at low priority beside the page from its first machine in
real time on: an identification then waits for ten minutes.

    build/venv/bin/python tests/readme/run_readme.py [--root FOLDER] [--from LINE] [--keep] [--ccache FOLDER]

A bare root (tests/readme/bare-root), a clone of the committed files in it, then one shell that gets every command of
every ```sh block of README.md, as a reader would type it. The first command that does not exit with 0 ends the run. The
output of each is in build/readme/NN-*.log. The RUN lines of docs/ci/Containerfile run in their own bare root
(tests/gate), and so does ./tools/test firmware: first to install its packages, then in a new clone within FIRMWARE_LIMIT_S.

With --ccache the first two roots have ccache as well, and what this machine has compiled before, from the same text with
the same compiler and flags, is not compiled again. ./tools/test firmware runs without it, because its time counts.
"""

from __future__ import annotations

import argparse
import os
import queue
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

from readme_blocks import Block, Kind, ReadmeError, blocks_of

PROJECT = Path(__file__).resolve().parents[2]
BARE_ROOT = PROJECT / "tests" / "readme" / "bare-root"
LOGS = PROJECT / "build" / "readme"
CLONE = "/home/user/trackservo"
COMMAND_LIMIT_S = 1500.0
READY_LIMIT_S = 60.0
FIRMWARE_TEST = "./tools/test firmware"
FIRMWARE_LIMIT_S = 60.0  # on two idle cores
SHELL = ("bash", "--noprofile", "--norc")


Cache = dict[str, str]
"""What bare-root needs in its environment to use a compiler cache; empty: none."""


class Failed(Exception):
    """A command of the README failed."""


class Terminal:
    """A shell in the root, in the clone; its output goes into `log` line by line."""

    def __init__(self, root: Path, name: str, cache: Cache) -> None:
        self.log = LOGS / f"{name}.log"
        self._log = self.log.open("w")
        self._lines: queue.Queue[str | None] = queue.Queue()
        self._process = subprocess.Popen(
            [str(BARE_ROOT), "run", str(root), *SHELL],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
            start_new_session=True, env={**os.environ, **cache},
        )  # fmt: skip
        threading.Thread(target=self._read, daemon=True).start()
        self._send(f"cd {CLONE}")

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._lines.put(line)
        self._lines.put(None)

    def _send(self, text: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(text + "\n")
        self._process.stdin.flush()

    def wait_for(self, wanted: str, limit_s: float) -> str:
        """The first line with `wanted` in it. The lines before it go to the log."""
        end = time.monotonic() + limit_s
        while True:
            try:
                line = self._lines.get(timeout=max(0.0, end - time.monotonic()))
            except queue.Empty:
                raise Failed(f"no '{wanted}' within {limit_s:.0f} s") from None
            if line is None:
                raise Failed(f"the command ended before it printed '{wanted}'")
            self._log.write(line)
            self._log.flush()
            if wanted in line:
                return line

    def run(self, command: str) -> None:
        """As typed; an exit code other than 0 is a failure. Its standard input is empty."""
        end_mark = "README-COMMAND-ENDED"
        self._log.write(f"$ {command}\n")
        self._send(f"{{ {command}\n}} </dev/null; printf '\\n{end_mark} %s\\n' $?")
        code = int(self.wait_for(end_mark + " ", COMMAND_LIMIT_S).split()[1])
        if code != 0:
            raise Failed(f"exit code {code}")

    def start(self, commands: tuple[str, ...], ready: str) -> None:
        """In the background of the reader: in its own terminal, from now on."""
        for command in commands:
            self._log.write(f"$ {command}\n")
            self._send(command)
        self.wait_for(ready, READY_LIMIT_S)

    def close(self, *, interrupt: bool = False) -> None:
        if interrupt:  # as Ctrl-C does: to all of the terminal
            os.killpg(self._process.pid, signal.SIGINT)
        assert self._process.stdin is not None
        try:
            self._process.stdin.close()
            self._process.wait(timeout=10)
        except (BrokenPipeError, subprocess.TimeoutExpired):
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
        self._log.close()


class Reader:
    """A reader who copies a page into terminals. `on_first_server` is called once, when a machine runs in real time."""

    def __init__(self, root: Path, cache: Cache, on_first_server: Callable[[], None], page: str = "README.md") -> None:
        self._page = page
        self._root = root
        self._cache = cache
        self._terminal = Terminal(root, "00-terminal", cache)
        self.log = self._terminal.log  # of the newest command
        self._server: Terminal | None = None
        self._count = 0
        self._on_first_server = on_first_server

    def follow(self, block: Block, previous: Block | None) -> None:
        if previous is not None and previous.headline != block.headline:
            self._stop_server()
        if block.kind is Kind.BACKGROUND:
            self._stop_server()
            self._count += 1
            if self._count == 1:
                self._on_first_server()
            self._server = Terminal(self._root, f"{self._count:02d}-background", self._cache)
            self.log = self._server.log
            self._timed(block.line, " ; ".join(block.commands), lambda: self._start_server(block))
            return
        self.log = self._terminal.log
        for command in block.to_run:
            self._timed(block.line, command, lambda command=command: self._terminal.run(command))

    def prepare(self, command: str) -> None:
        """What is not on the page."""
        self._terminal.run(command)

    def _start_server(self, block: Block) -> None:
        assert self._server is not None
        self._server.start(block.commands, block.detail)

    def _timed(self, line: int, command: str, action) -> None:
        started = time.monotonic()
        shown = " ".join(command.replace("\\\n", " ").split("#")[0].split())
        try:
            action()
        except Failed as failure:
            print(f"FAILED {self._page}:{line}: {shown}: {failure}", flush=True)
            raise
        print(f"ok {time.monotonic() - started:7.1f} s  {self._page}:{line}: {shown}", flush=True)

    def _stop_server(self) -> None:
        if self._server is not None:
            self._server.close(interrupt=True)
            self._server = None

    def close(self) -> None:
        self._stop_server()
        self._terminal.close()


def make_root(root: Path) -> None:
    """A bare Debian with a clone of the commit, as `git clone` makes it."""
    started = time.monotonic()
    subprocess.run([str(BARE_ROOT), "make", str(root)], check=True)
    clone(root)
    print(f"ok {time.monotonic() - started:7.1f} s  a bare Debian, and a clone in it", flush=True)


def install_ccache(root: Path) -> None:
    """The Debian package, before the first command of the page."""
    script = "apt-get -q update && apt-get -q -y install --no-install-recommends ccache"
    with (LOGS / "ccache.log").open("w") as log:
        command = [str(BARE_ROOT), "run", str(root), *SHELL, "-c", script]
        subprocess.run(command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, check=True)


def clone(root: Path) -> None:
    place = root / CLONE.lstrip("/")
    shutil.rmtree(place, ignore_errors=True)
    place.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run(["git", "clone", "--quiet", "--no-hardlinks", str(PROJECT), str(place)], check=True)


def run_container_file(root: Path, cache: Cache) -> bool:
    """The commands of `podman build`, in another bare root."""
    started = time.monotonic()
    clone(root)
    environment = {
        **os.environ,
        **cache,
        "GATE_WRAP": f"{BARE_ROOT} run {root}",
        "GATE_TREE": str(root / CLONE.lstrip("/")),
        "GATE_SHELL_TREE": CLONE,
    }
    pytest = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/gate/test_steps.py", "-k", "container"]
    good = run_low_priority(pytest, LOGS / "container-file.log", environment)[0] == 0
    took = time.monotonic() - started
    print(f"{'ok' if good else 'FAILED'} {took:7.1f} s  the RUN lines of docs/ci/Containerfile", flush=True)
    return good


def run_low_priority(command: list[str], log: Path, environment: Cache | None = None) -> tuple[int, float]:
    """Its exit code, and the CPU time in s of it and of its children. On a failure the end of its output is printed."""
    with log.open("w") as output:
        process = subprocess.Popen(
            ["nice", "-n", "19", *command],
            cwd=PROJECT, env=environment, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
        )  # fmt: skip
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        print(last_lines_of(log, 40), flush=True)
    return process.returncode, used.ru_utime + used.ru_stime


def run_firmware_tests(root: Path) -> bool:
    """From a clone to passed C tests in one command. The time is that of a clone when the packages are installed.

    On a busy machine the CPU time of two cores counts, if it is less than the time that has passed.
    """
    if FIRMWARE_TEST not in (PROJECT / "CONTRIBUTING.md").read_text():
        print(f"FAILED CONTRIBUTING.md does not name '{FIRMWARE_TEST}'", flush=True)
        return False
    took = on_two_cores_s = 0.0
    for name in ("packages", "tests"):
        clone(root)
        started = time.monotonic()
        command = [str(BARE_ROOT), "run", str(root), *SHELL, "-c", f"cd {CLONE} && {FIRMWARE_TEST}"]
        code, cpu_s = run_low_priority(command, LOGS / f"firmware-{name}.log")
        took, on_two_cores_s = time.monotonic() - started, cpu_s / 2.0
        if code != 0:
            print(f"FAILED {FIRMWARE_TEST}: exit code {code}", flush=True)
            return False
    good = min(took, on_two_cores_s) <= FIRMWARE_LIMIT_S
    print(f"{'ok' if good else 'FAILED'} {took:7.1f} s  {FIRMWARE_TEST} in a new clone "
          f"({on_two_cores_s:.1f} s of two cores; limit {FIRMWARE_LIMIT_S:.0f} s)", flush=True)  # fmt: skip
    return good


def last_lines_of(log: Path, count: int) -> str:
    return "\n".join(log.read_text(errors="replace").splitlines()[-count:])


class Beside:
    """What does not need the page's root, one after the other in a thread; a check that raises has failed."""

    def __init__(self, *checks: Callable[[], bool]) -> None:
        self._results = [False] * len(checks)
        self._checks = checks
        self._thread = threading.Thread(target=self._run)

    def start(self) -> None:
        self._thread.start()

    def _run(self) -> None:
        for index, check in enumerate(self._checks):
            self._results[index] = check()

    def results(self) -> list[bool]:
        """Waits for them; a reader who failed before a machine ran has not started them."""
        if self._thread.ident is None:
            self.start()
        self._thread.join()
        return self._results


def main() -> int:
    arguments = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    arguments.add_argument("--root", type=Path, help="use this existing root (bare-root make); it gets a new clone")
    arguments.add_argument("--keep", action="store_true", help="keep the created root afterwards")
    arguments.add_argument("--from", dest="first", type=int, default=1, help="begin at this line of the README (with --root)")
    arguments.add_argument("--ccache", type=Path, metavar="FOLDER", help="a compiler cache that the roots use (not with --root)")
    options = arguments.parse_args()
    if options.ccache and options.root:
        arguments.error("--ccache is for new roots: a given --root may have no ccache.")
    try:
        blocks = [block for block in blocks_of((PROJECT / "README.md").read_text()) if block.line >= options.first]
    except ReadmeError as error:
        print(f"README.md: {error}", file=sys.stderr)
        return 2
    shutil.rmtree(LOGS, ignore_errors=True)
    LOGS.mkdir(parents=True)
    root = options.root or PROJECT / "build" / "bare-root"
    container_root, firmware_root = (root.with_name(f"{root.name}-{name}") for name in ("container", "firmware"))
    cache = {"BARE_ROOT_CCACHE": str(options.ccache.resolve())} if options.ccache else {}
    if options.root is None:
        for old in (root, container_root, firmware_root):
            shutil.rmtree(old, ignore_errors=True)
        make_root(root)
        subprocess.run(["cp", "-a", str(root), str(firmware_root)], check=True)
        if cache:
            install_ccache(root)
        subprocess.run(["cp", "-a", str(root), str(container_root)], check=True)
    elif options.first == 1:
        clone(root)
    started = time.monotonic()
    others = (lambda: run_container_file(container_root, cache), lambda: run_firmware_tests(firmware_root))
    beside = Beside(*(others if options.root is None else ()))
    reader = Reader(root, cache, on_first_server=beside.start)
    passed = 0
    try:
        for previous, block in zip([None, *blocks], blocks):
            reader.follow(block, previous)
            passed += 1
    except Failed:
        print(last_lines_of(reader.log, 40))
    finally:
        reader.close()
    print(f"{passed} of {len(blocks)} blocks in {time.monotonic() - started:.0f} s", flush=True)
    failed = len(blocks) - passed
    for good in beside.results():
        passed, failed = passed + good, failed + (not good)
    if options.root is None:
        for made in [] if options.keep else [root, container_root, firmware_root]:
            shutil.rmtree(made)
    print(f"{passed} passed, {failed} failed")
    return 0 if failed == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
