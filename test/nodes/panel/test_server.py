"""The panel's server: whom it serves, what it bounds, and how it ends."""

from __future__ import annotations

import asyncio
import contextlib
import socket as sockets
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from aiohttp import ClientSession, WSMsgType, WSServerHandshakeError

from spatial_relations_ros.core import ConfigError, UnknownObjectError
from spatial_relations_ros.nodes.panel.commands import Command, ForgetCommand
from spatial_relations_ros.nodes.panel.hub import MAX_WAITING, Mailbox
from spatial_relations_ros.nodes.panel.origins import is_own_host, is_same_origin
from spatial_relations_ros.nodes.panel.server import MAX_BROWSERS, MAX_MESSAGE_BYTES, PanelServer
from spatial_relations_ros.ros.waiting import wait_until

LIMIT_SEC = 30.0


class Recorder:
    """Takes commands as the node does."""

    def __init__(self) -> None:
        self.commands: list[Command] = []

    def obey(self, command: Command) -> str:
        if isinstance(command, ForgetCommand):
            raise UnknownObjectError(f'{command.name} is not known')
        self.commands.append(command)
        return 'done'

    def model(self, key: str) -> str | None:
        return '{}' if key == '0123456789ab' else None


@pytest.fixture
def panel() -> Iterator[tuple[PanelServer, Recorder]]:
    recorder = Recorder()
    server = PanelServer(recorder, host='127.0.0.1', port=0, own_names=('robot.lab',))
    server.start()
    yield server, recorder
    server.close()
    assert not any(thread.name == 'panel' for thread in threading.enumerate())


def talk(server: PanelServer, conversation: Callable[[ClientSession], Any]) -> Any:
    async def run() -> Any:
        async with asyncio.timeout(LIMIT_SEC), ClientSession(server.address) as session:
            return await conversation(session)

    return asyncio.run(run())


def origin(server: PanelServer) -> str:
    return server.address.rstrip('/')


@pytest.mark.parametrize(
    ('host', 'is_own'),
    [
        ('127.0.0.1:8765', True), ('localhost', True), ('LOCALHOST:1', True), ('[::1]:80', True),
        ('10.0.0.7:8765', True), ('robot.lab:8765', True), ('robot.lab.:1', True),
        ('evil.example', False), ('127.0.0.1.evil.example', False), ('', False),
        ('localhost.evil.example:8765', False), ('[', False), ('robot.lab@evil.example', False),
    ],
)  # fmt: skip
def test_names_of_other_sites_are_not_served(host: str, is_own: bool) -> None:
    assert is_own_host(host, {'robot.lab'}) == is_own


def test_only_pages_of_the_same_host_and_port_may_connect() -> None:
    assert is_same_origin('http://localhost:8765', 'localhost:8765')
    assert is_same_origin('https://robot.lab', 'robot.lab')
    for bad in (
        None,
        '',
        'null',
        'http://localhost:1',
        'http://evil.example',
        'file://',
        'http://[',
    ):
        assert not is_same_origin(bad, 'localhost:8765')


def test_the_page_and_its_parts_come_with_strict_headers(
    panel: tuple[PanelServer, Recorder],
) -> None:
    async def conversation(session: ClientSession) -> None:
        for path in ('/', '/viewer.js', '/panel.css', '/model/0123456789ab'):
            async with session.get(path) as answer:
                assert answer.status == 200
                assert "default-src 'none'" in answer.headers['Content-Security-Policy']
                assert answer.headers['X-Content-Type-Options'] == 'nosniff'
        for path in ('/model/ffffffffffff', '/model/x', '/secret', '/..%2fserver.py'):
            async with session.get(path) as answer:
                assert answer.status == 404
        async with session.get('/', headers={'Host': 'evil.example'}) as answer:
            assert answer.status == 403
            assert 'allowed_hosts' in await answer.text()
        async with session.get('/', headers={'Host': 'robot.lab:8765'}) as answer:
            assert answer.status == 200

    talk(panel[0], conversation)


def test_foreign_pages_cannot_connect(panel: tuple[PanelServer, Recorder]) -> None:
    server, _ = panel

    async def conversation(session: ClientSession) -> None:
        for headers in ({}, {'Origin': 'http://evil.example'}, {'Origin': 'null'}):
            with pytest.raises(WSServerHandshakeError, match='403'):
                await session.ws_connect('/socket', headers=headers)
        rebound = {'Host': 'evil.example', 'Origin': 'http://evil.example'}
        with pytest.raises(WSServerHandshakeError, match='403'):
            await session.ws_connect('/socket', headers=rebound)

    talk(server, conversation)
    assert server.num_browsers == 0


def test_commands_are_answered_and_bad_ones_too(panel: tuple[PanelServer, Recorder]) -> None:
    server, recorder = panel
    server.publish('objects', {'objects': []})

    async def conversation(session: ClientSession) -> list[Any]:
        async with session.ws_connect('/socket', origin=origin(server)) as socket:
            replies = [await socket.receive_json()]
            for text in (
                '{"id": 1, "type": "cancel"}',
                '{"id": 2, "type": "forget", "name": "ghost"}',
                '{"id": 3, "type": "dance"}',
                'nonsense',
            ):
                await socket.send_str(text)
                replies.append(await socket.receive_json())
            await socket.send_bytes(b'x')
            replies.append(await socket.receive_json())
            return replies

    seen, done, unknown, *refused = talk(server, conversation)
    assert seen == {'type': 'objects', 'objects': []}, 'what was published before'
    assert done == {'type': 'reply', 'id': 1, 'ok': True, 'message': 'done'}
    assert unknown == {'type': 'reply', 'id': 2, 'ok': False, 'message': 'ghost is not known'}
    assert len(recorder.commands) == 1
    assert [reply['id'] for reply in refused] == [3, None, None]
    for reply in refused:
        assert not reply['ok']
        assert 'not understood' in reply['message']


def test_long_messages_end_the_connection_and_nothing_else(
    panel: tuple[PanelServer, Recorder],
) -> None:
    server, _ = panel

    async def conversation(session: ClientSession) -> None:
        async with session.ws_connect('/socket', origin=origin(server)) as socket:
            await socket.send_str('x' * (MAX_MESSAGE_BYTES + 1))
            message = await socket.receive()
            assert message.type in (WSMsgType.CLOSE, WSMsgType.CLOSED)
            assert socket.close_code == 1009
        async with session.ws_connect('/socket', origin=origin(server)) as socket:
            await socket.send_str('{"id": 1, "type": "cancel"}')
            assert (await socket.receive_json())['ok']

    talk(server, conversation)


def test_so_many_browsers_and_no_more(panel: tuple[PanelServer, Recorder]) -> None:
    server, _ = panel

    async def conversation(session: ClientSession) -> None:
        async with contextlib.AsyncExitStack() as stack:
            for _ in range(MAX_BROWSERS):
                await stack.enter_async_context(
                    session.ws_connect('/socket', origin=origin(server))
                )
            with pytest.raises(WSServerHandshakeError, match='503'):
                await session.ws_connect('/socket', origin=origin(server))

    talk(server, conversation)
    assert wait_until(lambda: server.num_browsers == 0, LIMIT_SEC)


def test_the_newest_message_of_a_subject_waits_and_never_many() -> None:
    async def run() -> list[str]:
        mailbox = Mailbox()
        for number in range(3 * MAX_WAITING):
            mailbox.post('objects', f'old {number}')
            mailbox.post(f'reply {number}', str(number))
        mailbox.post('objects', 'new')
        return await mailbox.take()

    texts = asyncio.run(run())
    assert len(texts) == MAX_WAITING
    assert texts[-1] == 'new'
    assert not any(text.startswith('old') for text in texts)


def test_a_port_that_is_taken_is_named(panel: tuple[PanelServer, Recorder]) -> None:
    with sockets.socket() as taken:
        taken.bind(('127.0.0.1', 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(ConfigError, match=f'port {port}.*set host and port'):
            PanelServer(panel[1], host='127.0.0.1', port=port).start()
    assert sum(thread.name == 'panel' for thread in threading.enumerate()) == 1
