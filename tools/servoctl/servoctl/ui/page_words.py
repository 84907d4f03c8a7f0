# SPDX-License-Identifier: Apache-2.0
"""Errors of the library in the words of the page: they name commands and options where the page has controls.

What only a command does (`servoctl scan`, `servoctl lss`) keeps its name.
"""

from __future__ import annotations

from ..wording import reworded, words_of

_STATE = r"'servoctl state (?:azimuth|pitch)"
_WORDS = words_of(
    (rf"{_STATE} reset'", "'Reset fault'"),
    (rf"{_STATE} disable'", "'Disable'"),
    (r"'servoctl faults' shows", "the tab Faults shows"),
    (r", e\.g\. 'servoctl move (?:azimuth|pitch) --to (-?\d+) --max-travel \d+'", r" with 'Move …' to \1°"),
    (r" 'servoctl set --apply --axis \w+' activates them, 'servoctl undo --staged --axis \w+' discards them", " 'Discard them' discards them"),
    (r"Run 'servoctl set --apply' or 'servoctl undo --staged' first", "Discard the staged values first"),
    (r"add --unlock to write it", "tick 'Unlock guarded gains' to write it"),
    (r"'servoctl save [^']*' writes", "'Save to file' writes"),
    (r"; 'servoctl explain' lists all names", ""),
    (r"; 'servoctl scope --list' lists (?:the signals|them)", ""),
    (r"--amplitude must not be 0, and --hold", "the rate of a step must not be 0, and its time"),
    (r"--amplitude must be greater than 0 and less than --bias", "the peak must be greater than 0 and less than the mean rate"),
    (r"--amplitude or --periods", "the peak or the number of periods"),
    (r"more --periods", "more periods"),
    (r"--bias must", "the mean rate must"),
    (r" \(--high\)", ""),
    (r"--travel-deg", "the travel"),
    (r"--speed-deg-s", "the rate"),
    (r"with --camera-id, e\.g\. --camera-id (\w+)", r"with the camera's identifier, e.g. \1"),
    (r"with --identify-program or", "in"),
)


def of_page(text: str) -> str:
    """The same for a reader of the page."""
    return reworded(text, _WORDS)
