"""The live panel in a headless Chromium, against the real nodes and the recorded bag."""

from __future__ import annotations

import asyncio
import json
import math
import re
from collections.abc import Iterator

import pytest
from aiohttp import ClientSession
from chromium import Browser
from demo_session import DemoSession
from ros_graph import ANSWER_SEC, START_SEC
from spatial_relations_msgs.srv import Forget, ListRelations

pytestmark = pytest.mark.ros

WIDE, NARROW = (1280, 900), (420, 900)


@pytest.fixture(scope='module')
def address(panel_address: str) -> str:
    return panel_address


@pytest.fixture
def page(browser: Browser, address: str) -> Iterator[Browser]:
    """The page with objects on it; its console must stay empty."""
    browser.open(address, size=WIDE)
    browser.wait("document.querySelectorAll('#objects tbody tr').length >= 7", 'the objects')
    browser.wait(f'{drawn("seen")}.length >= 7', 'their shapes')
    yield browser
    assert browser.console() == []


def drawn(view: str) -> str:
    return f'views.{view}.viewer.items'


def choose(page: Browser, name: str, object_ids: list[str]) -> None:
    for role, object_id in zip(('base', 'relative'), object_ids, strict=True):
        field = f'#{name}-{role}'
        page.wait(f'document.querySelector(\'{field} option[value="{object_id}"]\')', object_id)
        page.choose(field, object_id)


def unexpected(page: Browser) -> list[str]:
    """What the console says beside that nobody is there."""
    return [text for text in page.console() if 'ERR_CONNECTION_REFUSED' not in text]


def imitate(page: Browser) -> None:
    count = page.run('return Number(document.body.dataset.result || 0)')
    page.click('#imitate')
    page.wait(f'Number(document.body.dataset.result || 0) > {count}', 'an answer')
    page.wait("document.body.dataset.running === 'false'", 'the end of the imitation')


def test_it_shows_the_objects_and_how_far_they_are_believed(
    page: Browser, session: DemoSession
) -> None:
    rows = page.run(
        """return Object.fromEntries([...document.querySelectorAll('#objects tbody tr')]
        .map((row) => [row.dataset.id, row.querySelector('.state').innerText]))"""
    )
    ids = {*session.reference_ids, *session.test_ids}
    assert ids <= set(rows)
    assert {rows[object_id] for object_id in ids} == {'TRACKED'}
    assert page.colours('#seen') > 200
    labels = page.run("return [...byId('labels').children].map((label) => label.innerText)")
    assert ids <= {*labels}
    assert page.run(f'return {drawn("seen")}.some((item) => item.mesh.isCloud)') is False


def test_the_view_is_from_the_side_of_the_camera(page: Browser) -> None:
    page.wait('state.isPlaced', 'where the camera is')
    eye, target, azimuth, elevation = page.run(
        """const { target, azimuth, elevation } = views.seen.viewer.camera;
        return [state.eye, target, azimuth, elevation];"""
    )
    assert eye[2] > target[2], 'the camera of the bag looks down'
    assert azimuth == pytest.approx(math.atan2(eye[1] - target[1], eye[0] - target[0]))
    assert 0.2 < elevation < 1.5


def test_imitate_is_pressed_and_the_answer_shown(page: Browser, session: DemoSession) -> None:
    choose(page, 'reference', session.reference_ids)
    choose(page, 'test', session.test_ids)
    page.type('#answers-wanted', '2')
    imitate(page)
    assert page.find('#verdict b').text in ('imitated', 'not imitated')
    buttons = page.find_all('#answers button')
    assert 1 <= len(buttons) <= 2
    assert buttons[0].get_attribute('aria-pressed') == 'true'
    page.wait(f'{drawn("reference")}.length === 2', 'the demonstration')
    page.wait(f'{drawn("test")}.length === 3', 'the objects at their targets and a ghost')
    before, after = page.run(
        'return [state.result.test.objects[1].pose, state.result.answers[0].poses[1]]'
    )
    relative = f'return {drawn("test")}[1].pose'
    assert page.run(relative) == pytest.approx(after)
    page.find('#slider').send_keys('\ue011')  # Home
    assert page.run(relative) == pytest.approx(before)
    assert 'distance' in page.find('#checks').text
    assert page.colours('#test') > 200
    # What was answered went to the robot's topics as well.
    assert session.imitations[-1].targets[1].object_id == session.test_ids[1]


def test_the_time_that_it_may_take_reaches_the_node(page: Browser, session: DemoSession) -> None:
    choose(page, 'reference', session.reference_ids)
    choose(page, 'test', session.test_ids)
    page.type('#time-budget', '0.001')
    imitate(page)
    assert len(page.run('return state.result.history')) == 1, 'the scene as it stands alone'
    page.type('#time-budget', '60')
    imitate(page)
    assert len(page.run('return state.result.history')) > 1


def test_a_relation_is_remembered_listed_and_imitated_from(
    page: Browser, session: DemoSession
) -> None:
    name = '<img src=x onerror=alert(1)> "cup" & plate'
    choose(page, 'reference', session.reference_ids)
    choose(page, 'test', session.test_ids)
    page.type('#name', name)
    page.click('#remember')
    row = "[...byId('relations').children].find((row) => row.innerText.includes('onerror'))"
    page.wait(row, 'the remembered relation')
    assert page.find_all('#relations img') == [], 'names are text, not markup'
    page.type('#name', name)
    page.click('#remember')
    page.wait("document.querySelector('#relations-said').innerText.includes('replace')", 'refusal')
    assert name in list(session.call(ListRelations, '/metric_node/list').names)
    page.choose('#reference-name', name)
    assert not page.find('#reference-pair').is_displayed()
    imitate(page)
    assert 'plate' in page.find('#reference-legend').text
    assert session.call(Forget, '/metric_node/forget', name=name).success
    page.wait(f'!{row}', 'that it is gone')


def test_what_cannot_be_done_is_said(page: Browser, session: DemoSession) -> None:
    reply = 'return ask(arguments[0]).then((reply) => `${reply.ok} ${reply.message}`)'
    unknown = {'type': 'imitate', 'reference': ['ghost', 'cup'], 'test': session.test_ids}
    assert page.run(reply, unknown) == 'true asked'
    page.wait("document.querySelector('#said').innerText.includes('ghost')", 'the reason')
    for bad in ({'type': 'imitate', 'test': 'x'}, {'type': 'reboot'}):
        assert page.run(reply, bad).startswith('false not understood')
    choose(page, 'test', [session.test_ids[0]] * 2)
    assert not page.find('#imitate').is_enabled()


def test_another_browser_sees_the_same(page: Browser, session: DemoSession, address: str) -> None:
    """A second client, connected as its page would."""

    async def watch() -> list[str]:
        kinds: list[str] = []
        async with (
            asyncio.timeout(ANSWER_SEC),
            ClientSession(address) as client,
            client.ws_connect('/socket', origin=address.rstrip('/')) as socket,
        ):
            await asyncio.to_thread(page.click, '#imitate')
            async for message in socket:
                content = json.loads(message.data)
                if content['type'] == 'job' and content['running']:
                    kinds = ['job']
                elif kinds:
                    kinds.append(content['type'])
                if kinds and kinds[-1] == 'job' and not content['running']:
                    break
        return kinds

    choose(page, 'reference', session.reference_ids)
    choose(page, 'test', session.test_ids)
    assert {'progress', 'result'} <= set(asyncio.run(watch()))
    page.wait("document.body.dataset.running === 'false'", 'the end of the imitation')


@pytest.mark.parametrize('theme', ['light', 'dark'])
@pytest.mark.parametrize('size', [WIDE, NARROW], ids=['wide', 'narrow'])
def test_it_fits_windows_and_themes(
    page: Browser, theme: str, size: tuple[int, int], session: DemoSession
) -> None:
    page.show(size=size, theme=theme)
    assert page.overflow() == 0
    paper = page.run('return getComputedStyle(document.body).backgroundColor')
    levels = [int(level) for level in re.findall(r'\d+', paper)]
    assert max(levels) < 60 if theme == 'dark' else min(levels) > 240
    unnamed = page.run(
        """return [...document.querySelectorAll('select, input, button, canvas')]
        .filter((part) => !part.labels?.length && !part.ariaLabel && !part.innerText)
        .map((part) => part.id)"""
    )
    assert unnamed == [], 'everything that can be used has a name for screen readers'


def test_a_killed_panel_is_well_again_when_it_is_started(
    page: Browser, session: DemoSession, address: str
) -> None:
    graph = session.graph
    process = graph.processes.process('panel_node')
    process.kill()
    process.wait(60.0)
    page.wait("document.body.dataset.connection === 'lost'", 'the loss')
    port = int(re.search(r':(\d+)/', address)[1])
    models = str(session.plan.models_path)
    graph.processes.start('panel_node', parameters={'port': port, 'models_path': models})
    page.wait("document.body.dataset.connection === 'connected'", 'the new panel', START_SEC)
    page.wait("document.querySelectorAll('#objects tbody tr').length >= 7", 'the objects')
    choose(page, 'reference', session.reference_ids)
    choose(page, 'test', session.test_ids)
    imitate(page)
    assert page.find('#verdict b').text in ('imitated', 'not imitated')
    assert unexpected(page) == []


def test_it_survives_the_end_of_the_panel_and_of_other_nodes(
    page: Browser, session: DemoSession, address: str
) -> None:
    """The last test of the panel: it is started anew at its old address."""
    graph = session.graph
    process = graph.processes.process('panel_node')
    process.terminate()
    assert process.wait(60.0) == 0
    page.wait("document.body.dataset.connection === 'lost'", 'the loss')
    assert 'Traceback' not in graph.processes.log_path('panel_node').read_text()
    assert not page.find('#imitate').is_enabled()
    port = int(re.search(r':(\d+)/', address)[1])
    graph.processes.start(
        'panel_node',
        parameters={
            'port': port,
            'models_path': str(session.plan.models_path),
            # Nobody answers under these names: as if the other nodes had gone.
            'perception': 'nobody', 'metric': 'nobody_else', 'imitate_relation': 'nothing',
            'service_timeout': 0.2,
        },
    )  # fmt: skip
    page.wait("document.body.dataset.connection === 'connected'", 'the new panel', START_SEC)
    page.wait(
        "document.querySelector('#problem').innerText.includes('/nobody; is it running')",
        'what is wrong with perception',
    )
    page.wait(
        "document.querySelector('#relations-said').innerText.includes('no metric node')",
        'what is wrong with the memory',
    )
    assert unexpected(page) == []
