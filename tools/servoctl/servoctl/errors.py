# SPDX-License-Identifier: Apache-2.0
"""Possible errors, each with an exit code for scripts."""

from __future__ import annotations

from enum import IntEnum


class ExitCode(IntEnum):
    """Exit codes of every command."""

    OK = 0
    DIFFERENT = 1
    BAD_INPUT = 2
    NO_CONNECTION = 3
    REFUSED = 4
    NOT_VERIFIED = 5
    MOTION = 6
    SCHEMA = 7
    INTERNAL = 70
    INTERRUPTED = 130


EXIT_CODE_HELP = {
    ExitCode.OK: "done",
    ExitCode.DIFFERENT: (
        "diff found differences, scan found no node, identify could not determine all parameters, or tune"
        " restored the old gains"
    ),
    ExitCode.BAD_INPUT: "bad input: unknown name, value out of range, unusable file",
    ExitCode.NO_CONNECTION: "no bus, or no answer from the node",
    ExitCode.REFUSED: "the device refused; nothing of this command is active",
    ExitCode.NOT_VERIFIED: "the value read back differs from the value written",
    ExitCode.MOTION: "a motion was not possible or was aborted; the axis was brought to a safe state",
    ExitCode.SCHEMA: "the names of the device's objects are unknown (schema hash differs): see --parameters",
    ExitCode.INTERNAL: "internal error of servoctl; the axis was brought to a safe state",
    ExitCode.INTERRUPTED: "interrupted (Ctrl-C); the axis was brought to a safe state",
}


class ServoctlError(Exception):
    """One clear sentence for the user: what, where, and the remedy."""

    code = ExitCode.BAD_INPUT


class InputError(ServoctlError):
    """The command line or a file cannot be used."""


class ConnectionFailed(ServoctlError):
    """No bus or no answer."""

    code = ExitCode.NO_CONNECTION


class Refused(ServoctlError):
    """The device answered with an SDO abort, or did not accept a set of gains."""

    code = ExitCode.REFUSED

    def __init__(self, text: str, abort: int | None = None) -> None:
        super().__init__(text)
        self.abort = abort


class NotVerified(ServoctlError):
    """The device has another value than the written one."""

    code = ExitCode.NOT_VERIFIED


class MotionError(ServoctlError):
    """A motion cannot begin, or was aborted."""

    code = ExitCode.MOTION


class SchemaMismatch(ServoctlError):
    """The device has other objects than the parameters.json in use."""

    code = ExitCode.SCHEMA
