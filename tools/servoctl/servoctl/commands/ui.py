# SPDX-License-Identifier: Apache-2.0
"""ui: the page in the browser."""

from __future__ import annotations

import contextlib
import webbrowser
from pathlib import Path

import click

from ..errors import InputError
from ..link.bus import ENVIRONMENT, FORMS
from ..session import Session, common
from .quantity import Whole


@click.command(short_help="View, move and tune in the browser.")
@click.option("--demo", is_flag=True, help="Start the simulator, and show both of its axes moving.")
@click.option("--port", type=Whole(0, 65535), default=8642, show_default=True, help="Port of the page; 0: any free one.")
@click.option(
    "--host", default="127.0.0.1", show_default=True, metavar="ADDRESS",
    help="Address at which other computers reach the page, e.g. 0.0.0.0; the link then contains a token.",
)  # fmt: skip
@click.option("--no-browser", is_flag=True, help="Print the link, and open no browser.")
@common
def ui(session: Session, demo: bool, port: int, host: str, no_browser: bool) -> None:
    """Show the servo in the browser: signals at 1 kHz, states and faults, motion, and gains. Ctrl-C ends it.

    One page commands, the others view, and each can stop. The axes stop when the page that commands is closed or
    silent; when this program ends or the bus is lost, the device stops them by itself.
    """
    from ..sim_host import simulator
    from ..ui import demo as demonstration
    from ..ui.access import Access, in_link
    from ..ui.engine import Engine
    from ..ui.server import PAGE, Site, listen, web_server

    _need_plots(PAGE)
    if demo and session.bus_is_given:
        raise InputError("--demo starts a simulator of its own: give either --demo or --bus.")
    with contextlib.ExitStack() as stack:
        if demo:
            session.bus = stack.enter_context(simulator())
        elif not session.bus:
            raise InputError(f"no bus given: add --bus or set {ENVIRONMENT} to {FORMS}; --demo starts a simulator instead.")
        session.check_bus()
        engine = Engine(session.connect, f"node {session.node} on {session.bus}")
        opened = stack.enter_context(contextlib.closing(listen(host, port)))
        place = opened.getsockname()
        access = Access.of(host, place[1])
        link = f"http://{in_link(place[0])}:{place[1]}/" + (f"?token={access.token}" if access.token else "")
        session.out.json({"link": link, "bus": session.bus})
        session.out.say(f"servoctl ui: {link}   (Ctrl-C ends it)")
        if not no_browser:
            webbrowser.open(link)
        site = Site(engine, (lambda: demonstration.show_motion(engine)) if demo else None)
        with contextlib.suppress(KeyboardInterrupt):  # the usual end
            web_server(site, access).run(sockets=[opened])


def _need_plots(page: Path) -> None:
    if not (page / "uplot" / "uPlot.esm.js").is_file():
        raise InputError("the plot library uPlot is missing: run './tools/setup servoctl' in the checkout, or install the wheel.")
