"""The command `servoctl`: groups the commands and turns errors into one sentence and an exit code."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType
from typing import NoReturn

import can
import click

from . import __version__
from .commands import bode, faults, gains, identify, move, node, parameters, scope, step, tune, watch
from .errors import EXIT_CODE_HELP, ExitCode, ServoctlError

_EPILOG = "\b\nExit codes:\n" + "\n".join(f"  {code.value:>3}  {text}" for code, text in EXIT_CODE_HELP.items())

TRACEBACK = "SERVOCTL_TRACEBACK"

_COMPLETION = """\b
Completion of commands and parameter names:
  bash: eval "$(_SERVOCTL_COMPLETE=bash_source servoctl)"
  zsh:  eval "$(_SERVOCTL_COMPLETE=zsh_source servoctl)"
  fish: _SERVOCTL_COMPLETE=fish_source servoctl | source
"""


class Commands(click.Group):
    """Suggests the command that was meant."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """As in click, with a suggestion for a typo."""
        import difflib

        name = args[0] if args else ""
        if name and not name.startswith("-") and self.get_command(ctx, name) is None:
            close = difflib.get_close_matches(name, self.commands, n=1)
            hint = f"; did you mean '{close[0]}'?" if close else "; 'servoctl --help' lists the commands."
            ctx.fail(f"there is no command '{name}'{hint}")
        return super().resolve_command(ctx, args)


@click.group(
    cls=Commands, epilog=_COMPLETION + "\n\n" + _EPILOG, context_settings={"help_option_names": ["-h", "--help"]}
)
@click.version_option(__version__, message="servoctl %(version)s")
def servoctl() -> None:
    """Tunes a trackservo over CANopen, the simulator and the board alike.

    Parameters have names such as azimuth.speed_loop.proportional_gain; any unique ending will do, --axis completes it.
    What is shown is always read from the device. Options of a command come after its name.
    """


for _command in (
    node.scan, node.info, node.state,
    parameters.get, parameters.set_, parameters.undo, parameters.explain,
    gains.diff, gains.save, gains.restore, gains.store,
    move.move, step.step, bode.bode, identify.identify, tune.tune,
    scope.scope, watch.log, watch.monitor, faults.faults,
):  # fmt: skip
    servoctl.add_command(_command)


def _terminate(_signal: int, _frame: FrameType | None) -> NoReturn:
    """SIGTERM and SIGINT end a motion alike."""
    raise KeyboardInterrupt


def main(arguments: list[str] | None = None) -> int:
    """Runs one command and returns its exit code."""
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, _terminate)  # SIGINT, too: shells start background jobs deaf to it
    try:
        result = servoctl.main(args=arguments, prog_name="servoctl", standalone_mode=False)
        return int(result) if isinstance(result, int) else 0
    except ServoctlError as error:
        click.echo(f"servoctl: {error}", err=True)
        return int(error.code)
    except click.exceptions.Abort:
        click.echo("servoctl: interrupted.", err=True)
        return int(ExitCode.INTERRUPTED)
    except KeyboardInterrupt:
        click.echo("servoctl: interrupted.", err=True)
        return int(ExitCode.INTERRUPTED)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        return 0
    except click.ClickException as error:
        command = error.ctx.command_path if isinstance(error, click.UsageError) and error.ctx else "servoctl"
        click.echo(f"{command}: {error.format_message()}", err=True)
        return int(ExitCode.BAD_INPUT)
    except can.CanError as error:
        click.echo(f"servoctl: {error}.", err=True)
        return int(ExitCode.NO_CONNECTION)
    except BrokenPipeError:
        sys.stderr.close()
        return 0
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        click.echo(f"servoctl: {place}{error.strerror or error}.", err=True)
        return int(ExitCode.BAD_INPUT)
    except Exception as error:  # no user shall see a traceback unasked
        if os.environ.get(TRACEBACK):
            raise
        click.echo(f"servoctl: an error of servoctl itself: {error!r}; {TRACEBACK}=1 shows where.", err=True)
        return int(ExitCode.INTERNAL)


def run() -> NoReturn:
    """The entry point that pip installs."""
    sys.exit(main())
