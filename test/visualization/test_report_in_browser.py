"""The report page as a person uses it, in a headless Chromium without a network."""

from __future__ import annotations

import dataclasses

import pytest

from spatial_relations_ros.visualization import write_report

WIDE, NARROW = (1280, 900), (420, 800)


@pytest.fixture
def page(shown, browser, tmp_path):
    """Opens a page of two imitations; nothing may be said on its console."""
    other = dataclasses.replace(
        shown, title='<b>another</b>', success=False, answers=shown.answers[1:]
    )
    path = write_report(tmp_path / 'report.html', [shown, other])

    def open_page(place='', **look):
        browser.offline(True)
        browser.open(f'{path.as_uri()}{place}', **look)
        browser.wait("document.body.dataset.ready === 'yes'", 'the page')
        return browser

    yield open_page
    browser.offline(False)
    assert browser.console() == []


def state(browser):
    return browser.run('return {...document.body.dataset}')


@pytest.mark.parametrize('theme', ['light', 'dark'])
@pytest.mark.parametrize('size', [WIDE, NARROW], ids=['wide', 'narrow'])
def test_it_fits_the_window_and_draws_in_3d_in_both_themes(page, theme, size):
    browser = page(size=size, theme=theme)
    assert browser.overflow() == 0
    assert browser.find_all('.failed') == []
    for canvas in ('#reference', '#test'):
        assert browser.colours(canvas) > 50
    paper = browser.run('return getComputedStyle(document.body).backgroundColor')
    levels = [int(level) for level in paper[4:-1].split(',')]
    assert max(levels) < 60 if theme == 'dark' else min(levels) > 240
    tops = browser.run(
        "return ['reference', 'test'].map((id) => byId(id).getBoundingClientRect().top)"
    )
    assert (tops[0] == tops[1]) == (size == WIDE), 'beside each other where there is room'


def test_the_slider_moves_the_objects(page):
    browser = page()
    assert state(browser)['at'] == '2.00'
    after = browser.run("return document.querySelector('#test').toDataURL()")
    slider = browser.find('#slider')
    slider.send_keys('\ue011')  # Home
    assert state(browser)['at'] == '0.00'
    assert browser.find('#moment').text == 'before · distance 2.000'
    before = browser.run("return document.querySelector('#test').toDataURL()")
    assert before != after
    slider.send_keys('\ue00e' * 5)  # Page Up, a tenth each
    assert state(browser)['at'] == '1.00'
    assert 'best so far, 1 of 2, step 3' in browser.find('#moment').text
    browser.click('#play')
    browser.wait("document.body.dataset.at === '2.00'", 'the end of the play')


def test_answers_and_imitations_are_switched(page):
    browser = page('#answer=1&at=0.5')
    assert state(browser)['answer'] == '1'
    first, second = browser.find_all('#answers button')
    assert 'not feasible' in second.text
    assert second.get_attribute('aria-pressed') == 'true'
    assert not browser.find('#moments').is_displayed(), 'nobody measured distances on its way'
    first.click()
    assert browser.find('#moments').is_displayed()
    assert state(browser) == {'ready': 'yes', 'case': '0', 'answer': '0', 'at': '2.00'}
    assert first.get_attribute('aria-pressed') == 'true'
    assert '0.25' in browser.find('#checks').text
    browser.choose('#cases', '1')
    assert state(browser)['case'] == '1'
    assert len(browser.find_all('#answers button')) == 1
    assert browser.find('#verdict b').text == 'not imitated'
    assert browser.find('#cases').text.split('\n')[1].strip() == '<b>another</b>', (
        'text, no markup'
    )


def test_the_view_turns_by_drag_and_by_keys_and_both_views_together(page):
    browser = page()
    azimuths = 'return [views.reference.camera.azimuth, views.test.camera.azimuth]'
    start = browser.run(azimuths)
    browser.find('#test').send_keys('\ue012')  # left arrow
    turned = browser.run(azimuths)
    assert turned[0] == turned[1] != start[0]
    from selenium.webdriver import ActionChains

    ActionChains(browser.driver).drag_and_drop_by_offset(
        browser.find('#reference'), 60, 0
    ).perform()
    assert browser.run(azimuths)[1] != turned[1]


def test_the_theme_can_be_chosen(page):
    browser = page(theme='light')
    browser.click('#theme')
    assert browser.run('return document.documentElement.dataset.theme') == 'dark'
