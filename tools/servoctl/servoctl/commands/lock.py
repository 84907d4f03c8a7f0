# SPDX-License-Identifier: Apache-2.0
"""lock: the access lock of guarded parameters (3040)."""

from __future__ import annotations

import sys

import click

from ..errors import InputError
from ..link.device import Device
from ..objects.access_lock import WORD_BYTES, close_lock, lock_state, open_lock, set_word
from ..session import Session, common


@click.group()
def lock() -> None:
    """Open, close and set the access lock of the guarded parameters (3040).

    Motor data (2055), protection limits (2060) and board scales (3060) can be written only while the lock is open and
    no axis has torque. 'set', 'restore', 'undo' and 'tune' open it by themselves with --unlock. The owner may set a word;
    without one everybody can open the lock. It protects against mistakes and against clients without the word. It does
    not protect against someone who listens to the bus or has access to the device.
    """


def _show(session: Session, device: Device) -> None:
    state = lock_state(device)
    session.out.json({"open_s": state.open_s, "has_word": state.has_word, "delay_s": state.delay_s})
    is_open = f"open for another {state.open_s} s on this SDO channel" if state.open_s else "closed"
    word = "the owner has set a word" if state.has_word else "no word is set"
    delay = f"; no word is accepted for {state.delay_s} s" if state.delay_s else ""
    session.out.say(f"The access lock of node {device.node_id} is {is_open}; {word}{delay}.")


@lock.command("status", short_help="Show whether the lock is open and a word is set.")
@common
def status(session: Session) -> None:
    """Show whether the lock is open and a word is set."""
    with session.connect() as device:
        _show(session, device)


@lock.command("open", short_help="Open the lock for 60 s.")
@common
def open_(session: Session) -> None:
    """Open the lock for 60 s, for all clients of the first SDO channel. Give the owner's word with --word."""
    with session.connect() as device:
        open_lock(device)
        _show(session, device)


@lock.command("close", short_help="Close the lock.")
@common
def close(session: Session) -> None:
    """Close the lock."""
    with session.connect() as device:
        close_lock(device)
        _show(session, device)


@lock.command("set-word", short_help="Set or remove the owner's word.")
@click.option(
    "--new", metavar="WORD", envvar="SERVOCTL_NEW_WORD",
    help=f"The new word, 1 to {WORD_BYTES} characters (environment: SERVOCTL_NEW_WORD); servoctl prompts for it if it is missing.",
)  # fmt: skip
@click.option("--remove", is_flag=True, help="Remove the word: then everybody can open the lock.")
@common
def set_word_(session: Session, new: str | None, remove: bool) -> None:
    """Set the owner's word, or remove it. The device stores it at once. Give the present word with --word.

    Nobody can read the word back. A lost word is recovered at the device: docs/can.md.
    """
    if remove and new:
        raise InputError("--new and --remove exclude each other.")
    if not remove and not new:
        if sys.stdin is None or not sys.stdin.isatty():
            raise InputError("give the new word with --new or in SERVOCTL_NEW_WORD, or remove the word with --remove.")
        new = str(click.prompt("New access word", hide_input=True, confirmation_prompt=True, err=True))
    with session.connect() as device:
        set_word(device, None if remove else new)
        _show(session, device)
