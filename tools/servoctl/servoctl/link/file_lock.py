# SPDX-License-Identifier: Apache-2.0
"""A lock that the servoctl processes of one user and computer share. The kernel frees the locks of a process that ends."""

from __future__ import annotations

import contextlib
import getpass
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

if sys.platform == "win32":
    from portalocker import AlreadyLocked, LockFlags
    from portalocker.portalocker import Win32Locker

    _LOCKER = Win32Locker()  # the other one of Windows has no shared locks, and gives up waiting after 10 s

    def _take(file: BinaryIO, shared: bool, waits: bool) -> None:
        """Raises BlockingIOError if another process has it and we do not wait. Windows changes no lock: ours goes first."""
        flags = LockFlags.SHARED if shared else LockFlags.EXCLUSIVE
        _free(file)
        try:
            _LOCKER.lock(file, flags if waits else flags | LockFlags.NON_BLOCKING)
        except AlreadyLocked as error:
            raise BlockingIOError from error

    def _free(file: BinaryIO) -> None:
        _LOCKER.unlock(file)  # no error if there was none

    def _user() -> str:
        return getpass.getuser()

else:
    import fcntl

    def _take(file: BinaryIO, shared: bool, waits: bool) -> None:
        """Raises BlockingIOError if another process has it and we do not wait."""
        flags = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
        fcntl.flock(file, flags if waits else flags | fcntl.LOCK_NB)

    def _free(file: BinaryIO) -> None:
        fcntl.flock(file, fcntl.LOCK_UN)

    def _user() -> str:
        return str(os.getuid())


class FileLock:
    """A lock in a file of the user, in the system's folder for locks; the file stays for other processes, with its
    text."""

    def __init__(self, name: str) -> None:
        folder = Path(os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir())
        descriptor = os.open(folder / f"servoctl-{_user()}-{name}.lock", os.O_RDWR | os.O_CREAT, 0o600)
        self._file: BinaryIO = os.fdopen(descriptor, "r+b", buffering=0)

    def wait(self, shared: bool = False) -> None:
        """Takes it, alone or shared; changes a lock that we already have."""
        _take(self._file, shared, waits=True)

    def try_alone(self) -> bool:
        """Takes it alone if no other process has it; otherwise the lock that we had is lost."""
        try:
            _take(self._file, shared=False, waits=False)
        except BlockingIOError:
            return False
        return True

    def release(self) -> None:
        """For the next one."""
        _free(self._file)

    @contextlib.contextmanager
    def held(self, shared: bool = False) -> Iterator[None]:
        """Within a `with` block."""
        self.wait(shared)
        try:
            yield
        finally:
            self.release()

    @property
    def text(self) -> str:
        """Contents of the file."""
        self._file.seek(0)
        return self._file.read(100).decode("ascii", errors="replace")

    @text.setter
    def text(self, text: str) -> None:
        self._file.truncate(0)
        self._file.seek(0)
        self._file.write(text.encode("ascii"))

    def close(self) -> None:
        """Releases it too."""
        self._file.close()
