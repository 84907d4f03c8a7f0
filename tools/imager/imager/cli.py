# SPDX-License-Identifier: Apache-2.0
"""The command `imager`: one source, one node; errors are one sentence and exit code 2."""

from __future__ import annotations

import contextlib
import math
import re
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn
from urllib.parse import unquote

import can
import click
from servoctl.link.bus import BIT_RATES, ENVIRONMENT, parse_bus
from servoctl.link.bus import FORMS as BUS_FORMS
from servoctl.commands.quantity import Whole
from servoctl.link.device import Device
from servoctl.errors import ServoctlError
from servoctl.show.output_files import check_new, overwrite_option
from servoctl.motion.tracking import DROPS
from servoctl.units import is_plain

from . import __version__
from .camera import CameraMode
from .camera_frame import AGE, NODE_CLOCK, FrameSender, Result
from .errors import ImagerError
from .follower import TRACKERS, Follower, Sighting
from .picture import DEFAULT_PIXEL_URAD, Optics, Picture
from .recorder import Recorder
from .sources import NewestPicture, Source, open_source
from .statistics import Statistics
from .video import DEFAULT_RATE_HZ
from .view import View


class _Size(click.ParamType[tuple[int, int]]):
    """Of a picture, as 1920x1080."""

    name = "WIDTHxHEIGHT"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, int]:
        if not (match := re.fullmatch(r"([0-9]{1,5})[xX]([0-9]{1,5})", value)) or not int(match[1]) or not int(match[2]):
            self.fail(f"'{value}' is not a size; expected WIDTHxHEIGHT in pixels, as 1920x1080.", param, ctx)
        return int(match[1]), int(match[2])


class _PixelFormat(click.ParamType[str]):
    """As Video4Linux names them."""

    name = "FORMAT"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        if not re.fullmatch(r"[A-Za-z0-9]{3,4}", value):
            self.fail(f"'{value}' is not a pixel format; expected its name, as MJPG, YUYV, GREY or Y16.", param, ctx)
        return str(value)


class _Number(click.FloatRange):
    """Refuses nan, which is in every range of click, and what only Python takes for a number, as 1_000."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if isinstance(value, str) and not is_plain(value):
            self.fail(f"'{value}' is not a number.", param, ctx)
        found = float(super().convert(value, param, ctx))
        if not math.isfinite(found):
            self.fail(f"{value} is not a finite number.", param, ctx)
        return found


BAD_INPUT, INTERNAL = 2, 70
THREAD_SWITCH_S = 5e-4
"""The reading thread must not wait for the computing one at each piece of a picture."""
STATUS_PERIOD_S = 1.0


@dataclass(frozen=True)
class Settings:
    """Of one run."""

    optics: Optics
    tracker: str
    camera_delay_s: float
    seconds: float | None
    quiet: bool


def process(
    source: Source, pictures: NewestPicture, settings: Settings, sender: FrameSender | None, recorder: Recorder | None
) -> Statistics:
    """Every picture becomes a frame, until the source or the time ends, or Ctrl-C comes."""
    follower = Follower(settings.tracker)
    statistics = Statistics()
    start_s = next_status_s = time.monotonic()
    view = View(settings.optics)
    last: Picture | None = None
    with contextlib.suppress(KeyboardInterrupt):
        for picture in pictures:
            optics = view.of(picture)
            passed = picture.progress - last.progress if last else 1.0
            sighting = follower.take(picture.grey, passed if passed > 0.0 else 1.0)
            last = picture
            error_rad = optics.error(sighting.column, sighting.row, picture.grey.shape)
            delay_s = _send(source, picture, sighting, error_rad, settings, sender)
            statistics.take(sighting, error_rad, delay_s)
            statistics.shape = view.first
            if recorder is not None:
                recorder.write(picture, sighting, error_rad)
            now_s = time.monotonic()
            if now_s >= next_status_s and not settings.quiet:
                next_status_s = now_s + STATUS_PERIOD_S
                click.echo(_status(now_s - start_s, sighting, error_rad, delay_s))
            if settings.seconds is not None and now_s - start_s >= settings.seconds:
                break
    return statistics


def _send(
    source: Source, picture: Picture, sighting: Sighting, error_rad: tuple[float, float], settings: Settings,
    sender: FrameSender | None,
) -> float:  # fmt: skip
    """Returns the delay: since the exposure, or since the arrival if only the node's clock times the exposure."""
    now_s = time.monotonic()
    age_s = now_s - picture.exposed_s + settings.camera_delay_s
    if sender is not None:
        stamp_s = picture.exposed_s - settings.camera_delay_s if source.node_clock else age_s
        sender.send(Result(*error_rad, stamp_s, sighting.quality))
        now_s = time.monotonic()
    return now_s - picture.arrived_s if source.node_clock else now_s - picture.exposed_s + settings.camera_delay_s


def _status(seconds: float, sighting: Sighting, error_rad: tuple[float, float], delay_s: float) -> str:
    text = f"{seconds:7.1f} s  {sighting.state.value}"
    if sighting.quality:
        text += f"  x {1e6 * error_rad[0]:+8.1f}  y {1e6 * error_rad[1]:+8.1f} µrad  quality {sighting.quality:3d}"
    return f"{text}  delay {1e3 * delay_s:.1f} ms"


def _summary(
    source: Source, pictures: NewestPicture, statistics: Statistics, settings: Settings, sender: FrameSender | None
) -> None:
    delay = "arrival of the picture to frame sent" if source.node_clock else "exposure to frame sent"
    click.echo(f"pictures: {statistics.pictures}, skipped because newer ones had come: {pictures.skipped}")
    click.echo(f"delay, {delay}: {statistics.delay()}")
    click.echo(f"{statistics.errors(settings.optics.pixel_rad)}.")
    if statistics.shape and not statistics.found:
        height, width = statistics.shape[:2]
        across, up = (0.5e3 * side * settings.optics.pixel_rad for side in (width, height))
        click.echo(
            f"The picture shows ±{across:.1f} by ±{up:.1f} mrad around the line of sight (--pixel-urad): a cue that is further off"
            " does not show the target. Nothing in it stood out from its surroundings."
        )
    if sender is not None:
        report = sender.report()
        taken, dropped = report.taken - sender.at_start.taken, report.dropped - sender.at_start.dropped
        text = f"frames: {sender.sent} sent, {taken} taken and {dropped} dropped by the node"
        if dropped:
            text += f"; last reason: {DROPS.get(report.last_drop, str(report.last_drop))}"
        elif sender.sent and not taken:
            text += "; the node takes PDOs only while it is operational: 'servoctl info' shows its state"
        if sender.clipped:
            text += (
                f"; {sender.clipped} errors were beyond ±{1e3 * sender.range_rad:.1f} mrad and sent as that: give the node a larger"
                " unit (3071:1)"
            )
        click.echo(f"{text}; from exposure to use in the node: {report.age_ms} ms at last")


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("source")
@click.option("--bus", envvar=ENVIRONMENT, show_envvar=True, help=f"CAN bus of the node: {BUS_FORMS}.")
@click.option("--no-bus", is_flag=True, help="Send nothing, to try a camera or a video.")
@click.option("--node", type=Whole(1, 127), default=1, show_default=True, help="Node id.")
@click.option("--bitrate", type=click.Choice([str(rate) for rate in BIT_RATES]), default="1000000", show_default=True)
@click.option("--record", type=click.Path(dir_okay=False, path_type=Path), help="Write a video with overlay (.avi, .mp4, .mkv).")
@click.option("--pixel-urad", type=_Number(0.01, 1e4), default=DEFAULT_PIXEL_URAD, show_default=True,
              help="Angle of one pixel in the middle of the picture: its size / focal length.")  # fmt: skip
@click.option("--azimuth-grows", type=click.Choice(["left", "right"]), default="left", show_default=True,
              help="Side of the picture where the azimuth is larger.")  # fmt: skip
@click.option("--tracker", type=click.Choice(TRACKERS), default="kcf", show_default=True,
              help="OpenCV's tracker that takes over where the target does not stand out.")  # fmt: skip
@click.option("--camera-delay", type=_Number(-100.0, 100.0), default=0.0, show_default=True,
              help="From the middle of the exposure to the picture's time stamp, ms; of a stamp of its start: minus half of it.")  # fmt: skip
@click.option("--size", type=_Size(), help="Size of the camera's pictures in pixels, as 1920x1080; default 640x480, or what is nearest.")
@click.option("--pixel-format", type=_PixelFormat(), help="Pixel format of the camera, as MJPG, YUYV, GREY or Y16.")
@click.option("--rate", type=_Number(1e-3, 1e3),
              help=f"Pictures per second of the camera, or of a folder, whose files say no times (default {DEFAULT_RATE_HZ:g}).")  # fmt: skip
@click.option("--seconds", type=_Number(0.1), help="End after so many seconds.")
@click.option("--quiet", is_flag=True, help="No line each second.")
@overwrite_option
@click.version_option(__version__, message="imager %(version)s")
def imager(
    source: str, bus: str | None, no_bus: bool, node: int, bitrate: str, record: Path | None, pixel_urad: float,
    azimuth_grows: str, tracker: str, camera_delay: float, size: tuple[int, int] | None, pixel_format: str | None,
    rate: float | None, seconds: float | None, quiet: bool, overwrite: bool,
) -> None:  # fmt: skip
    """Finds a target in the pictures of SOURCE, follows it, and sends its error to a trackservo as camera frames.

    SOURCE is a camera's number (0) or device (/dev/video0), a video file, a folder of pictures (PNG, TIFF ...), an rtsp://
    or http:// address, or pgm-tcp:HOST:PORT, the pictures of 'sim_host serve --video'. It ends at the end of a video, or
    with Ctrl-C.
    """
    address = None if no_bus else parse_bus(bus)
    settings = Settings(Optics(1e-6 * pixel_urad, azimuth_grows == "right"), tracker, 1e-3 * camera_delay, seconds, quiet)
    if record is not None:
        check_new([record], overwrite, "--record", [Path(source), *_files_of_address(source)])
    with contextlib.ExitStack() as stack:
        opened = open_source(source, CameraMode(size, rate, pixel_format))
        stack.callback(opened.close)
        if record is not None and opened.is_playlist and record.is_file():
            raise ImagerError(f"--record '{record}' exists already, and the playlist '{source}' may play it: give a new name.")
        recorder = Recorder(record, opened.rate_hz) if record else None
        if recorder is not None:
            stack.callback(recorder.close)
        pictures = NewestPicture(opened)  # from now on none gets old
        stack.callback(pictures.close)
        sender = None
        if address is not None:
            device = stack.enter_context(Device(address, node, bitrate=int(bitrate)))
            sender = stack.enter_context(FrameSender(device, NODE_CLOCK if opened.node_clock else AGE))
        statistics = process(opened, pictures, settings, sender, recorder)
        _summary(opened, pictures, statistics, settings, sender)
        if opened.damage:
            raise ImagerError(opened.damage)


def _files_of_address(source: str) -> list[Path]:
    """What an address may name on this computer: file:///a.mkv, concat:a.mkv|b.mkv, async:file:a.mkv."""
    parts = source.split(":")
    rests = (":".join(parts[n:]) for n in range(1, len(parts)))
    return [Path(unquote(file.removeprefix("//"))) for rest in rests for file in rest.split("|")]


def _terminate(_signal: int, _frame: FrameType | None) -> NoReturn:
    """SIGTERM and SIGINT end a run alike."""
    raise KeyboardInterrupt


def main(arguments: list[str] | None = None) -> int:
    """Runs the command and returns its exit code."""
    sys.setswitchinterval(THREAD_SWITCH_S)
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, _terminate)
    try:
        imager.main(args=arguments, prog_name="imager", standalone_mode=False)
        return 0
    except (ImagerError, ServoctlError) as error:
        text, code = str(error), BAD_INPUT
    except (click.exceptions.Abort, KeyboardInterrupt):
        return 0
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        return 0
    except click.ClickException as error:
        text, code = error.format_message(), BAD_INPUT
    except can.CanError as error:
        text, code = f"{error}.", BAD_INPUT
    except OSError as error:
        text, code = f"{error.filename or 'system'}: {error.strerror or error}.", BAD_INPUT
    except Exception as error:
        text, code = f"internal error of imager: {error!r}.", INTERNAL
    click.echo(f"imager: {text}", err=True)
    return code


def run() -> NoReturn:
    """The entry point that pip installs."""
    sys.exit(main())
