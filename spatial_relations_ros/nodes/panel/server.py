"""The panel's web server: one page, shapes, and a WebSocket, in a thread of its own."""

from __future__ import annotations

import asyncio
import contextlib
import functools
import re
import threading
from collections.abc import Awaitable, Callable, Collection, Mapping
from importlib import resources
from typing import Any, Protocol

from aiohttp import WSMsgType, web

from spatial_relations_ros.core import ConfigError, SpatialRelationsError
from spatial_relations_ros.nodes.panel.commands import Command, CommandError, read_command
from spatial_relations_ros.nodes.panel.hub import Hub, Mailbox, as_json
from spatial_relations_ros.nodes.panel.origins import is_own_host, is_same_origin
from spatial_relations_ros.visualization.report import page_part

MAX_MESSAGE_BYTES = 16 * 1024
MAX_BROWSERS = 16
START_SEC = 30.0
HEARTBEAT_SEC = 20.0

_OWN_PARTS = ('index.html', 'panel.css', 'scene.js', 'panel.js')
_REPORT_PARTS = ('report.css', 'matrices.js', 'viewer.js', 'curve.js')
_TYPES = {'html': 'text/html', 'css': 'text/css', 'js': 'text/javascript'}
_HEADERS = {
    'Content-Security-Policy': (
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
        "img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    'X-Content-Type-Options': 'nosniff',
    'Referrer-Policy': 'no-referrer',
    'Cross-Origin-Resource-Policy': 'same-origin',
    'Cache-Control': 'no-cache',
}


class Panel(Protocol):
    """What the server asks of the node, on threads of its own; calls may wait."""

    def obey(self, command: Command) -> str:
        """Carries out a command; what came of it, in words.

        Raises:
            SpatialRelationsError: why it cannot be carried out.
        """

    def model(self, key: str) -> str | None:
        """The shape of that key as JSON text; None when there is none."""


class PanelServer:
    """Serves the panel to browsers.

    Args:
        panel: is asked.
        host: address to listen on.
        port: to listen on; 0 takes a free one.
        own_names: further host names under which browsers may come.
    """

    def __init__(
        self, panel: Panel, *, host: str, port: int, own_names: Collection[str] = ()
    ) -> None:
        self._panel, self._host, self._port = panel, host, port
        self._own_names = frozenset(name.lower() for name in (*own_names, host))
        self._parts = {name: _own_part(name) for name in _OWN_PARTS}
        self._parts |= {name: page_part(name) for name in _REPORT_PARTS}
        self._hub = Hub()
        self._sockets: set[web.WebSocketResponse] = set()
        self._loop = asyncio.new_event_loop()
        self._started = threading.Event()
        self._failure: OSError | None = None
        self._stop = asyncio.Event()
        self._thread = threading.Thread(target=self._run, name='panel', daemon=True)
        self.address = ''

    @property
    def num_browsers(self) -> int:
        """Browsers that look at the panel now."""
        return len(self._hub)

    def start(self) -> str:
        """Starts to serve; returns the address of the page.

        Raises:
            ConfigError: when the address cannot be listened on.
        """
        self._thread.start()
        self._started.wait(START_SEC)
        if self._failure is not None or not self.address:
            self.close()
            raise ConfigError(
                f'cannot listen on {self._host}, port {self._port}: '
                f'{self._failure or "the server does not start"}; set host and port'
            )
        return self.address

    def publish(
        self, subject: str, content: Mapping[str, Any], *, only_changes: bool = False
    ) -> None:
        """Sends a message to all browsers; from any thread, without waiting.

        Args:
            subject: ``objects``, ``relations``, ``job``, ``progress`` or ``result``.
            content: of the message.
            only_changes: sends nothing when it says what the last one said.
        """
        send = functools.partial(self._hub.publish, only_changes=only_changes)
        with contextlib.suppress(RuntimeError):  # the server has ended
            self._loop.call_soon_threadsafe(send, subject, content)

    def close(self) -> None:
        """Says goodbye to browsers and ends the thread."""
        if self._thread.is_alive():
            with contextlib.suppress(RuntimeError):  # it ends already
                self._loop.call_soon_threadsafe(self._stop.set)
            self._thread.join()

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve())
            # The commands that are being carried out use the node.
            self._loop.run_until_complete(self._loop.shutdown_default_executor())
        finally:
            self._started.set()
            self._loop.close()

    async def _serve(self) -> None:
        app = web.Application(middlewares=[self._guard], client_max_size=MAX_MESSAGE_BYTES)
        app.on_response_prepare.append(_add_headers)
        app.on_shutdown.append(self._say_goodbye)
        app.add_routes(
            [
                web.get('/', self._page),
                web.get('/socket', self._socket),
                web.get('/model/{key}', self._model),
                web.get('/{part}', self._page),
            ]
        )
        runner = web.AppRunner(app, shutdown_timeout=1.0, access_log=None)
        await runner.setup()
        try:
            await web.TCPSite(runner, self._host, self._port).start()
            host, port = runner.addresses[0][:2]
            self.address = f'http://{f"[{host}]" if ":" in host else host}:{port}/'
            self._started.set()
            await self._stop.wait()
        except OSError as error:
            self._failure = error
        finally:
            await runner.cleanup()

    @web.middleware
    async def _guard(
        self,
        request: web.Request,
        handler: Callable[[web.Request], Awaitable[web.StreamResponse]],
    ) -> web.StreamResponse:
        if not is_own_host(request.host, self._own_names):
            raise web.HTTPForbidden(
                text='This is not the name of this panel. Names that it may have are given by '
                'the parameter allowed_hosts.'
            )
        return await handler(request)

    async def _page(self, request: web.Request) -> web.Response:
        name = request.match_info.get('part', 'index.html')
        if name not in self._parts:
            raise web.HTTPNotFound
        kind = _TYPES[name.rpartition('.')[2]]
        return web.Response(text=self._parts[name], content_type=kind, charset='utf-8')

    async def _model(self, request: web.Request) -> web.Response:
        key = request.match_info['key']
        text = self._panel.model(key) if re.fullmatch('[0-9a-f]{12}', key) else None
        if text is None:
            raise web.HTTPNotFound
        # A key is made of the content.
        headers = {'Cache-Control': 'private, max-age=86400, immutable'}
        return web.Response(text=text, content_type='application/json', headers=headers)

    async def _socket(self, request: web.Request) -> web.WebSocketResponse:
        if not is_same_origin(request.headers.get('Origin'), request.host):
            raise web.HTTPForbidden(text='Only the page of this panel may connect.')
        if len(self._hub) >= MAX_BROWSERS:
            raise web.HTTPServiceUnavailable(text=f'{MAX_BROWSERS} browsers are connected.')
        socket = web.WebSocketResponse(max_msg_size=MAX_MESSAGE_BYTES, heartbeat=HEARTBEAT_SEC)
        await socket.prepare(request)
        mailbox = self._hub.join()
        self._sockets.add(socket)
        writer = asyncio.create_task(_write(socket, mailbox))
        try:
            async for message in socket:
                text = message.data if message.type is WSMsgType.TEXT else ''
                await self._answer(text, mailbox)
        finally:
            writer.cancel()
            self._sockets.discard(socket)
            self._hub.leave(mailbox)
        return socket

    async def _answer(self, text: str, mailbox: Mailbox) -> None:
        """One command after the other: a browser cannot have many under way."""
        number: int | None = None
        try:
            number, command = read_command(text)
            said = await asyncio.to_thread(self._panel.obey, command)
            reply = {'ok': True, 'message': said}
        except CommandError as error:
            number = error.number
            reply = {'ok': False, 'message': f'not understood: {error}'}
        except SpatialRelationsError as error:
            reply = {'ok': False, 'message': str(error)}
        mailbox.post(f'reply {number}', as_json({'type': 'reply', 'id': number, **reply}))

    async def _say_goodbye(self, _: web.Application) -> None:
        for socket in set(self._sockets):
            await socket.close(code=1001, message=b'the panel ends')


async def _write(socket: web.WebSocketResponse, mailbox: Mailbox) -> None:
    while not socket.closed:
        for text in await mailbox.take():
            await socket.send_str(text)


async def _add_headers(_: web.Request, response: web.StreamResponse) -> None:
    for name, value in _HEADERS.items():
        response.headers.setdefault(name, value)


def _own_part(name: str) -> str:
    return resources.files(__package__).joinpath('static', name).read_text(encoding='utf-8')
