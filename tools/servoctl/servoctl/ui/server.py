# SPDX-License-Identifier: Apache-2.0
"""The web server: the page and its files, and one WebSocket for each open page.

    from the page   {"id": 7, "do": "jog", "axis": 0, "rate_deg_s": 2}, answered by {"reply": 7, "result": ...} or "error"
    to the page     {"state": ...} ten times a second, {"events": [...]}, and samples as binary messages (`pack`)
"""

from __future__ import annotations

import asyncio
import base64
import contextlib
import json
import socket
import struct
import time
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import HTTPConnection, Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from ..errors import InputError, ServoctlError
from ..gains.gains_file import MAX_BYTES, GainsFile, parse_gains
from ..link.signal_stream import Samples
from ..objects.parameter import AXES
from ..show import recording
from ..show.text_file import text_of
from . import commission
from .access import COOKIE, Access
from .engine import Engine, Order, file_error, internal, is_of_a_file
from .jobs import Jobs
from .page_words import of_page
from .viewers import Viewer, Viewers

PAGE = Path(__file__).resolve().parent / "page"
BATCH_S = 0.025
SHOWN_S = 600.0
"""Of a recording at once."""
STATE_S = 0.1
MOST_READINGS = 8
"""That one page may wait for; ours asks for one or two."""
WEBSOCKET_BYTES = 1 << 18
"""Of one message; a gains file has MAX_BYTES at most."""
_HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}
_REPORT_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
"""Of a report: its style is inside, and it runs no script."""
_HEAD = struct.Struct("<II")


def pack(samples: Samples) -> bytes:
    """Number of samples and of signals, the ticks (u32), then all values of each signal (float32), little endian."""
    signals, count = samples.values.shape
    return _HEAD.pack(count, signals) + samples.ticks.astype("<u4").tobytes() + samples.values.astype("<f4").tobytes()


class Guard:
    """Refuses requests that are not from our page, and adds the headers."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app = app
        self._access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        connection = HTTPConnection(scope)
        token = connection.query_params.get("token", "")
        refusal = self._access.refusal(connection.headers, token, scope["type"] == "websocket")
        if refusal is not None:
            if scope["type"] == "websocket":
                await WebSocket(scope, receive, send).close(1008, refusal)
            else:
                await PlainTextResponse(refusal, 403)(scope, receive, send)
            return

        async def send_with_headers(message: Any) -> None:
            if message["type"] == "http.response.start":
                present = {name for name, _ in message["headers"]}
                more = ((k.lower().encode(), v.encode()) for k, v in _HEADERS.items())
                message["headers"] = [*message["headers"], *((k, v) for k, v in more if k not in present)]
            await send(message)

        await self._app(scope, receive, send_with_headers)


class Site:
    """What the server does with messages."""

    def __init__(self, engine: Engine, demo: Callable[[], None] | None = None) -> None:
        """`demo` runs once the server is there."""
        self._engine = engine
        self._viewers = Viewers()
        self._parser, self._closer = ThreadPoolExecutor(1), ThreadPoolExecutor(1)
        """One file at a time; and what must not wait for files that are read."""
        self._demo = demo
        self._told = ""

    def app(self, access: Access) -> Starlette:
        """The application."""
        return Starlette(
            routes=[
                Route("/", self._index),
                WebSocketRoute("/ws", self._socket),
                Route("/recordings", _recordings),
                Route("/recordings/{name}", _recording),
                Route("/recordings/{name}/samples", _recorded_samples),
                Route("/commissioning", _commissioned),
                Route("/commissioning/{name}", _commissioned_details),
                Route("/commissioning/{name}/{file}", _commissioned_file),
                Mount("/", StaticFiles(directory=PAGE)),
            ],
            middleware=[Middleware(Guard, access=access)],
            lifespan=self._lifespan,
        )

    @contextlib.asynccontextmanager
    async def _lifespan(self, _app: Starlette) -> AsyncIterator[None]:
        self._engine.start()
        tasks = [asyncio.create_task(self._repeat(BATCH_S, self._send_samples)), asyncio.create_task(self._repeat(STATE_S, self._send_states))]
        if self._demo is not None:
            asyncio.get_running_loop().run_in_executor(None, self._demo)
        try:
            yield
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.get_running_loop().run_in_executor(self._closer, self._engine.close)
            self._parser.shutdown(wait=False, cancel_futures=True)

    async def _index(self, request: Request) -> Response:
        token = request.query_params.get("token")
        if token:  # checked by the guard; the address without it can be shown to anyone
            response = RedirectResponse("/")
            response.set_cookie(COOKIE, token, httponly=True, samesite="strict")
            return response
        return Response((PAGE / "index.html").read_bytes(), media_type="text/html")

    # --- to the pages ---------------------------------------------------------------------------------------------

    async def _repeat(self, period_s: float, send: Callable[[], None]) -> None:
        while True:
            await asyncio.sleep(period_s)
            try:
                send()
            except Exception as error:  # noqa: BLE001 - the page shows it once, and what comes next is sent
                if self._told != (text := internal(error)):
                    self._told = text
                    self._engine.say(text, "bad")

    def _send_samples(self) -> None:
        samples = self._engine.samples()
        if samples is not None and len(samples.ticks):
            data = pack(samples)
            for viewer in self._viewers.all:
                viewer.send_samples(data)

    def _send_states(self) -> None:
        for viewer in self._viewers.all:
            self._send_state(viewer)

    def _send_state(self, viewer: Viewer) -> None:
        viewer.send({"state": self._engine.state() | {"pages": self._viewers.data(viewer), "time": time.time()}})
        events = self._engine.events(viewer.last_event)
        if events:
            viewer.last_event = events[-1]["number"]
            viewer.send({"events": events})

    # --- from a page ----------------------------------------------------------------------------------------------

    async def _socket(self, socket: WebSocket) -> None:
        await socket.accept()
        viewer = self._viewers.join(_browser(socket.headers.get("user-agent", "")))
        self._send_state(viewer)
        sender = asyncio.create_task(_send_all(socket, viewer))
        try:
            while True:
                self._take(viewer, json.loads(await socket.receive_text()))
        except (WebSocketDisconnect, RuntimeError, ValueError, TypeError, AttributeError, LookupError, OverflowError):
            pass  # RuntimeError: closed while it was sent to; the others: what is no request closes it, too
        finally:
            sender.cancel()
            if self._viewers.part(viewer):
                self._engine.commander_seen(False)
                if self._engine.anything_held:
                    self._engine.stop(f"page {viewer.number}, which commanded, was closed")

    def _take(self, viewer: Viewer, message: dict[str, Any]) -> None:
        """Quick things at once, all others in a task of their own."""
        what = message.get("do")
        if what == "stop":
            self._engine.stop(f"STOP on page {viewer.number}")
        elif what == "beat" and self._viewers.commander is viewer:
            self._engine.commander_seen()
            return
        elif what == "held" and self._viewers.commander is viewer:
            self._engine.jog_held(int(message["axis"]))
            return
        elif what in ("beat", "held"):
            return
        if self._viewers.commander is viewer:
            self._engine.commander_seen()  # what it orders is supervised, also after a stop because it was silent
        order = self._engine.order(lambda: self._viewers.commander is viewer)  # now: a stop that comes next is a later one
        task = asyncio.create_task(self._answer(viewer, message, order))
        _TASKS.add(task)
        task.add_done_callback(_TASKS.discard)

    async def _answer(self, viewer: Viewer, message: dict[str, Any], order: Order) -> None:
        number = message.get("id")
        try:
            with viewer.reads(MOST_READINGS) if message.get("do") in _FOR_ALL else contextlib.nullcontext():
                viewer.send({"reply": number, "result": await self._do(viewer, message, order)})
        except ServoctlError as error:
            viewer.send({"reply": number, "error": of_page(str(error))})
        except OSError as error:
            viewer.send({"reply": number, "error": file_error(error) if is_of_a_file(error) else str(error)})
        except (LookupError, TypeError, ValueError, OverflowError) as error:
            viewer.send({"reply": number, "error": f"the page sent an invalid request: {error!r}."})
        except Exception as error:  # noqa: BLE001 - one sentence for the page
            viewer.send({"reply": number, "error": internal(error)})

    async def _do(self, viewer: Viewer, message: dict[str, Any], order: Order) -> Any:
        what = message.get("do")
        if what == "stop":
            return None
        if what == "take":
            before = self._viewers.commander
            self._viewers.take(viewer, self._engine.commander_is_silent)
            if before not in (None, viewer) and self._engine.anything_held:  # the silence would have ended it in this moment
                self._engine.stop(f"page {viewer.number} took command from a silent page")
            self._engine.commander_seen()
            self._engine.say(f"page {viewer.number} ({viewer.name}) commands")
            return None
        if what == "release":
            if self._viewers.release(viewer):
                self._engine.commander_seen(False)
                self._engine.say(f"page {viewer.number} commands no longer")
                if self._engine.anything_held:
                    self._engine.stop(f"page {viewer.number} released command")
            return None
        if what in ("end_recording", "restore", "start_node"):
            self._viewers.need(viewer)  # a viewer's file is not even parsed
        if what == "end_recording":
            return await asyncio.get_running_loop().run_in_executor(self._closer, self._engine.end_recording)
        if what in ("compare", "restore"):
            message = message | {"file": await self._gains_file(message)}
        if what == "start_node" and not self._engine.connected:
            return self._engine.start_when_found()
        job = _job(str(what), message)
        if what in _FOR_ALL:
            return await asyncio.wrap_future(self._engine.submit(job))
        self._viewers.need(viewer)
        return await asyncio.wrap_future(self._engine.submit(job, order))

    async def _gains_file(self, message: dict[str, Any]) -> GainsFile:
        """That of a message, parsed beside the thread of the bus."""
        path, content = Path(str(message["name"])), base64.b64decode(str(message["base64"]), validate=True)
        if len(content) > MAX_BYTES:
            raise InputError(f"{path} is no gains file: it has {len(content) // 1000} kB, and at most {MAX_BYTES // 1000} kB are read.")
        schema = await asyncio.wrap_future(self._engine.submit(lambda jobs: jobs.schema()))
        parse = partial(parse_gains, path=path, schema=schema)
        return await asyncio.get_running_loop().run_in_executor(self._parser, lambda: parse(text_of(path, content).text))


# --- recordings -------------------------------------------------------------------------------------------------------


async def _recordings(_request: Request) -> Response:
    """Newest first."""
    found = sorted(recording.folder().glob("*.mcap"), key=lambda path: path.stat().st_mtime, reverse=True)
    return JSONResponse([{"name": path.name, "bytes": path.stat().st_size, "time": path.stat().st_mtime} for path in found])


async def _recording(request: Request) -> Response:
    """The file itself."""
    try:
        return FileResponse(recording.find(request.path_params["name"]), filename=request.path_params["name"])
    except InputError as error:
        return PlainTextResponse(str(error), 404)


async def _recorded_samples(request: Request) -> Response:
    """At most SHOWN_S of it from `from` s on: the length of a description, the description (JSON), and samples (`pack`)."""
    try:
        path = recording.find(request.path_params["name"])
        from_s = _real({"from_s": request.query_params.get("from", "0")}, "from_s")
        found = await asyncio.to_thread(recording.read, path, from_s, SHOWN_S)
    except (InputError, ValueError) as error:
        return PlainTextResponse(str(error), 404)
    signals = [{"name": s.name, "unit": s.unit, "plot": s.plot, "axis": s.axis} for s in found.signals]
    head = json.dumps({"signals": signals, "period_ms": found.period_ms, "whole": found.whole, "begun": found.begun.isoformat()}).encode()
    head += b" " * (-len(head) % 4)
    return Response(struct.pack("<I", len(head)) + head + pack(found.samples), media_type="application/octet-stream")


# --- commissioning ----------------------------------------------------------------------------------------------------


async def _commissioned(_request: Request) -> Response:
    """All identifications in the folder of the page."""
    return await _answered(commission.overview)


async def _commissioned_details(request: Request) -> Response:
    """One of them."""
    return await _answered(partial(commission.details, request.path_params["name"]))


async def _answered(found: Callable[[], Any]) -> Response:
    try:
        return JSONResponse(await asyncio.to_thread(found))
    except (InputError, OSError) as error:
        return PlainTextResponse(str(error), 404)
    except (KeyError, TypeError, ValueError) as error:
        return PlainTextResponse(f"a file of this identification was not written by servoctl: {error!r}.", 404)


async def _commissioned_file(request: Request) -> Response:
    """A file of one, as the command line makes it; reports have their style and pictures inside."""
    try:
        path = commission.find_file(request.path_params["name"], request.path_params["file"])
    except InputError as error:
        return PlainTextResponse(str(error), 404)
    kind = "text/html" if path.suffix == ".html" else "text/plain"
    return FileResponse(path, media_type=kind, headers={"Content-Security-Policy": _REPORT_POLICY})


_TASKS: set[asyncio.Task[None]] = set()
_FOR_ALL = ("faults", "gains", "plan", "plan_step", "plan_cue", "plan_follow", "save", "compare", "plan_bode", "predict", "scope_names", "dry_run", "plan_tune", "plan_shape")
"""They change nothing."""


def _job(what: str, message: dict[str, Any]) -> Callable[[Jobs], Any]:
    """A message as a job; raises InputError for an unknown one, KeyError or ValueError when something is missing."""
    if what in ("enable", "disable", "reset", "release_jog", "hold", "gains", "discard", "predict"):
        axis = _axis(message)
        name = "release" if what == "release_jog" else what
        return lambda jobs: getattr(jobs, name)(axis)
    if what in ("start_node", "faults", "plan_follow", "end_follow", "save", "store", "scope_names", "scope_force", "scope_stop", "scope_read", "record"):
        return lambda jobs: getattr(jobs, what)()
    if what == "jog":
        axis, rate = _axis(message), _real(message, "rate_deg_s")
        return lambda jobs: jobs.jog(axis, rate)
    if what in ("plan", "move", "swing"):
        axis, angle, rate = _axis(message), _real(message, "angle_deg"), _real(message, "rate_deg_s")
        if what == "plan":
            relative = bool(message["relative"])
            return lambda jobs: jobs.plan(axis, relative, angle, rate)
        place = _real(message, "from_deg")
        return lambda jobs: getattr(jobs, what)(axis, angle, rate, place)
    if what in ("plan_step", "step"):
        axis, amplitude, hold = _axis(message), _real(message, "amplitude_deg_s"), _real(message, "hold_s")
        return lambda jobs: getattr(jobs, what)(axis, amplitude, hold)
    if what in ("plan_shape", "shape"):
        axis, shape, periods = _axis(message), str(message["shape"]), int(_real(message, "periods"))
        travel, period = _real(message, "travel_deg"), _real(message, "period_s")
        return lambda jobs: getattr(jobs, what)(axis, shape, travel, period, periods)
    if what in ("plan_bode", "bode"):
        axis = _axis(message)
        numbers = [_real(message, key) for key in ("low_hz", "high_hz", "bias_deg_s", "amplitude_deg_s")]
        periods = int(_real(message, "periods"))
        return lambda jobs: getattr(jobs, what)(axis, *numbers, periods)
    if what in ("plan_cue", "cue"):
        angles, rate = [_real(message, f"{name}_deg") for name in AXES], _real(message, "rate_deg_s")
        target_rate = _optional(message, "target_rate_deg_s")
        if what == "plan_cue":
            return lambda jobs: jobs.plan_cue(angles, rate, target_rate)
        places = [_real(message, f"{name}_from_deg") for name in AXES]
        return lambda jobs: jobs.cue(angles, rate, target_rate, places)
    if what == "scope_arm":
        signals, on, trigger = [int(each) for each in message["signals"]], int(message["on"]), str(message["trigger"])
        rate, duration, pre, level = (_real(message, key) for key in ("rate_hz", "duration_s", "pre_s", "level"))
        return lambda jobs: jobs.scope_arm(signals, rate, duration, pre, trigger, on, level)
    if what == "follow":
        identifier = str(message["camera_id"]).strip()
        following = {axis: _real(message, f"{name}_from_deg") for axis, name in enumerate(AXES) if f"{name}_from_deg" in message}
        return lambda jobs: jobs.follow(identifier, following)
    if what == "choose":
        choice = str(message["choice"])
        return lambda jobs: jobs.choose(choice)
    if what == "apply":
        values = {str(name): str(text) for name, text in dict(message["values"]).items()}
        unlock, word = _lock(message)
        return lambda jobs: jobs.apply(values, unlock, word)
    if what == "undo":
        unlock, word = _lock(message)
        return lambda jobs: jobs.undo(unlock, word)
    if what in ("compare", "restore"):
        file = message["file"]
        if what == "compare":
            return lambda jobs: jobs.compare(file)
        unlock, word = _lock(message)
        return lambda jobs: jobs.restore(file, unlock, word)
    found = _commission_job(what, message)
    if found is not None:
        return found
    raise InputError(f"the page sent an unknown request '{what}'.")


def _commission_job(what: str, message: dict[str, Any]) -> Callable[[Jobs], Any] | None:
    """One of the steps; None for another request."""
    if what in ("dry_run", "begin"):
        axis, speed = _axis(message), _optional(message, "rate_deg_s")
        ends = _optional(message, "low_deg"), _optional(message, "high_deg")
        if (ends[0] is None) != (ends[1] is None):
            raise InputError("give both ends of the travel, or none.")
        travel = None if ends[0] is None or ends[1] is None else (ends[0], ends[1])
        if what == "begin":
            return lambda jobs: jobs.commission.begin(axis, travel, speed)
        name, step = str(message.get("name") or ""), str(message["step"])
        return lambda jobs: jobs.commission.dry_run(axis, name, step, travel, speed)
    if what in ("look", "identify"):
        name = str(message["name"])
        return lambda jobs: getattr(jobs.commission, what)(name)
    if what not in ("design", "plan_tune", "tune"):
        return None
    name = str(message["name"])
    stimulus: list[float] = []
    if what != "design":
        stimulus = [*(_real(message, key) for key in ("bias_deg_s", "amplitude_deg_s", "high_hz")), int(_real(message, "periods"))]
    if what == "plan_tune":
        return lambda jobs: jobs.commission.plan_tune(name, *stimulus)
    given = dict(message["requirements"])
    requirements = {str(key): _real(given, key) for key in given}
    unlock, word = _lock(message)
    if what == "design":
        return lambda jobs: jobs.commission.design(name, requirements, unlock)
    return lambda jobs: jobs.commission.tune(name, requirements, unlock, word, *stimulus)


def _optional(message: dict[str, Any], key: str) -> float | None:
    return None if message.get(key) is None else _real(message, key)


def _axis(message: dict[str, Any]) -> int:
    axis = int(message["axis"])
    if axis not in (0, 1):
        raise ValueError(f"axis {axis}")
    return axis


def _lock(message: dict[str, Any]) -> tuple[bool, str]:
    """Whether to open the access lock, and the owner's word."""
    return message.get("unlock") is True, str(message.get("word") or "")


def _field(key: str) -> str:
    """What a key of a message means, with its unit: 'rate, °/s'."""
    for suffix, unit in (("_deg_s", "°/s"), ("_deg", "°"), ("_hz", "Hz"), ("_s", "s")):
        if key.endswith(suffix):
            return f"'{key.removesuffix(suffix).replace('_', ' ')}, {unit}'"
    return f"'{key}'"


def _real(message: dict[str, Any], key: str) -> float:
    if message[key] is None:
        raise InputError(f"enter a number: the field for {_field(key)} holds none.")
    value = float(message[key])
    if not np.isfinite(value):
        raise ValueError(f"{key} is not finite")
    return value


async def _send_all(socket: WebSocket, viewer: Viewer) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        while True:
            message = await viewer.queue.get()
            if isinstance(message, str):
                await socket.send_text(message)
            else:
                await socket.send_bytes(message)


def _browser(agent: str) -> str:
    """A few words about it."""
    kind = next((name for name in ("Firefox", "Edg", "Chrome", "Safari") if name in agent), "browser")
    place = next((name for name in ("Android", "iPhone", "iPad", "Windows", "Macintosh", "Linux") if name in agent), "")
    return " on ".join(part for part in ({"Edg": "Edge"}.get(kind, kind), place) if part)


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens there; raises InputError."""
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        opened = socket.socket(family, socket.SOCK_STREAM)
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        opened.bind((host, port))
        opened.listen(16)
    except OSError as error:
        raise InputError(f"the page cannot be served at {host}:{port}: {error.strerror or error}. Give another --port.") from error
    return opened


def web_server(site: Site, access: Access) -> uvicorn.Server:
    """Its `run` ends with Ctrl-C or SIGTERM; then the axes are at rest."""
    config = uvicorn.Config(
        site.app(access), log_level="error", ws_ping_interval=2.0, ws_ping_timeout=4.0, ws_per_message_deflate=False,
        lifespan="on", timeout_graceful_shutdown=1, ws_max_size=WEBSOCKET_BYTES,
    )  # fmt: skip
    return uvicorn.Server(config)
