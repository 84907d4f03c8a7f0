# SPDX-License-Identifier: Apache-2.0
"""Errors of the library in the words of who reads them: they name the options of the commands."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import ContextDecorator
from types import TracebackType

from .errors import ServoctlError

Words = Sequence[tuple[re.Pattern[str], str]]


def words_of(*pairs: tuple[str, str]) -> Words:
    """From pairs of a regular expression and what takes its place."""
    return [(re.compile(pattern), words) for pattern, words in pairs]


def reworded(text: str, words: Words) -> str:
    """The same in these words."""
    for pattern, replacement in words:
        text = pattern.sub(replacement, text)
    return text


_PYTHON = words_of(
    (r"'servoctl state (azimuth|pitch) (reset|disable)'", r"\1.\2()"),
    (r"add --unlock to write it", "give unlock=True to write it"),
    (r"'servoctl set' and 'servoctl restore' apply such gains with --override-gain-check", "set and restore apply such gains with override=True"),
    (r"give it with --word or in", "give it to connect as word, or in"),
    (r"with --parameters FILE", "to connect as parameters"),
    (r"Give the full name or --axis", "Give the full name"),
    (r", or raise --max-\w+", ", or give other limits"),
    (r"--travel-deg (-?[\d.e+]+) (-?[\d.e+]+)", r"a travel of \1° to \2°"),
    (r"--travel-deg needs two angles in °", "travel_rad needs two angles in rad"),
    (r"--speed-deg-s 20", "fastest_rad_s=0.35"),
    (r"--speed-deg-s", "fastest_rad_s"),
    (r"--amplitude must not be 0, and --hold", "amplitude_rad_s must not be 0, and hold_s"),
    (r"--amplitude must be greater than 0 and less than --bias", "amplitude must be greater than 0 and less than bias"),
    (r"--amplitude or --periods", "amplitude or periods"),
    (r"more --periods", "more periods"),
    (r"--bias must not", "bias must not"),
    (r" \(--high\)", " (high)"),
    (r"with --camera-id, e\.g\. --camera-id (\w+)", r"with camera_id, e.g. camera_id=0x\1"),
    (r"add --overwrite to replace it", "give overwrite=True to replace it"),
    (r" with --from", ""),
    (r"--(limits|plant|scenario|seeds|out):", r"\1:"),
    (r"with --identify-program or", "in"),
)


class _InPython(ContextDecorator):
    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if isinstance(error, ServoctlError):
            error.args = (reworded(str(error), _PYTHON), *error.args[1:])


in_python = _InPython()
"""For a function or a `with` block: errors in it name arguments where they name options."""
