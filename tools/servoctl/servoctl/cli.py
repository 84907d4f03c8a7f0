# SPDX-License-Identifier: Apache-2.0
"""The command `servoctl`: groups the commands and turns errors into one sentence and an exit code."""

from __future__ import annotations

import json
import os
import signal
import sys
import textwrap
from types import FrameType
from typing import NoReturn

import can
import click

from . import __version__
from .commands import (
    bode,
    braking,
    camera,
    faults,
    follow,
    gains,
    home,
    identify,
    lock,
    lss,
    monitoring,
    move,
    node,
    parameters,
    scope,
    step,
    track,
    tune,
    ui,
)
from .errors import EXIT_CODE_HELP, ExitCode, ServoctlError
from .show.output import wrapped

_JSON = """With --json, results are written as JSON to standard output. An error is one line of JSON on standard error,
{"error": {"exit_code": 2, "kind": "bad_input", "message": "..."}}, a note is {"note": "..."}. Exit codes are the same.
"""

_EPILOG = "\b\nExit codes:\n" + "\n".join(
    textwrap.fill(text, 76, initial_indent=f"  {code.value:>3}  ", subsequent_indent=" " * 7)
    for code, text in EXIT_CODE_HELP.items()
)

TRACEBACK = "SERVOCTL_TRACEBACK"

_COMPLETION = """\b
Completion of commands and parameter names:
  bash: eval "$(_SERVOCTL_COMPLETE=bash_source servoctl)"
  zsh:  eval "$(_SERVOCTL_COMPLETE=zsh_source servoctl)"
  fish: _SERVOCTL_COMPLETE=fish_source servoctl | source
"""


class Commands(click.Group):
    """Suggests the intended command."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """As in click, with a suggestion for a typo."""
        import difflib

        name = args[0] if args else ""
        if name and not name.startswith("-") and self.get_command(ctx, name) is None:
            close = difflib.get_close_matches(name, self.commands, n=1)
            hint = f"; did you mean '{close[0]}'?" if close else "; 'servoctl --help' lists the commands."
            ctx.fail(f"unknown command '{name}'{hint}")
        return super().resolve_command(ctx, args)


@click.group(
    cls=Commands, epilog=_COMPLETION + "\n\n" + _JSON + "\n" + _EPILOG, context_settings={"help_option_names": ["-h", "--help"]}
)
@click.version_option(__version__, message="servoctl %(version)s")
def servoctl() -> None:
    """Tunes a trackservo over CANopen. Works with the simulator and the board.

    Parameters have names such as azimuth.speed_loop.proportional_gain. A unique ending of the name is enough; --axis
    adds the axis. All values shown are read from the device. Options follow the name of the command.
    """


for _command in (
    node.scan, node.info, node.state,
    parameters.get, parameters.set_, parameters.undo, parameters.explain,
    gains.diff, gains.save, gains.restore, gains.store,
    move.move, home.home, track.track, follow.follow, step.step, bode.bode, braking.braking, identify.identify, tune.tune, camera.camera,
    scope.scope, monitoring.log, monitoring.monitor, faults.faults, lock.lock, lss.lss,
    ui.ui,
):  # fmt: skip
    servoctl.add_command(_command)


def _terminate(_signal: int, _frame: FrameType | None) -> NoReturn:
    """SIGTERM and SIGINT end a motion alike."""
    raise KeyboardInterrupt


def _wants_json(arguments: list[str]) -> bool:
    """Also when the command line is otherwise not understood."""
    return "--json" in arguments[: arguments.index("--")] if "--" in arguments else "--json" in arguments


def _report(text: str, code: ExitCode, as_json: bool, command: str = "servoctl") -> int:
    """One sentence, or with --json one JSON object, on the error stream; the exit code is the same."""
    if as_json:
        reported = {"error": {"exit_code": int(code), "kind": code.name.lower(), "message": text}}
        click.echo(json.dumps(reported, ensure_ascii=False), err=True)
    else:
        click.echo(wrapped(f"{command}: {text}", sys.stderr), err=True)
    return int(code)


def main(arguments: list[str] | None = None) -> int:
    """Runs one command and returns its exit code."""
    as_json = _wants_json(sys.argv[1:] if arguments is None else arguments)
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, _terminate)  # SIGINT, too: shells start background jobs deaf to it
    try:
        result = servoctl.main(args=arguments, prog_name="servoctl", standalone_mode=False)
        return int(result) if isinstance(result, int) else 0
    except ServoctlError as error:
        return _report(str(error), error.code, as_json)
    except (click.exceptions.Abort, KeyboardInterrupt):
        return _report("interrupted.", ExitCode.INTERRUPTED, as_json)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        return 0
    except click.ClickException as error:
        command = error.ctx.command_path if isinstance(error, click.UsageError) and error.ctx else "servoctl"
        return _report(error.format_message(), ExitCode.BAD_INPUT, as_json, command)
    except can.CanError as error:
        return _report(f"{error}.", ExitCode.NO_CONNECTION, as_json)
    except BrokenPipeError:
        sys.stderr.close()
        return 0
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        return _report(f"{place}{error.strerror or error}.", ExitCode.BAD_INPUT, as_json)
    except Exception as error:  # no traceback for users, unless requested
        if os.environ.get(TRACEBACK):
            raise
        text = f"internal error of servoctl: {error!r}. Set {TRACEBACK}=1 to see the traceback."
        return _report(text, ExitCode.INTERNAL, as_json)


def run() -> NoReturn:
    """The entry point that pip installs."""
    sys.exit(main())
