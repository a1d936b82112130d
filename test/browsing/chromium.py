"""A headless Chromium for tests of pages, driven by Selenium."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

BROWSER = next(filter(None, map(shutil.which, ('chromium', 'google-chrome', 'chrome'))), None)
DRIVER = shutil.which('chromedriver')
# Limits, not waits: a busy machine needs seconds to draw with a software renderer.
WAIT_SEC = 60.0

FLAGS = (
    '--headless=new', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage',
    # WebGL without a GPU.
    '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
    '--disable-quic', '--no-first-run', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', '--disable-extensions', '--hide-scrollbars',
)  # fmt: skip


class Browser:
    """A Chromium with an empty profile; it is shared by tests, pages are not."""

    def __init__(self, profile: Path) -> None:
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service

        options = webdriver.ChromeOptions()
        options.binary_location = BROWSER
        for flag in (*FLAGS, f'--user-data-dir={profile}'):
            options.add_argument(flag)
        options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
        self.driver = webdriver.Chrome(options=options, service=Service(DRIVER))
        self.driver.set_script_timeout(WAIT_SEC)

    def open(self, address: str, *, size: tuple[int, int] = (1280, 900), theme: str = 'light'):
        """Loads a page with nothing left of the page before, not even its log."""
        self.driver.get('about:blank')
        self.console()
        self.show(size=size, theme=theme)
        self.driver.get(address)

    def show(self, *, size: tuple[int, int] | None = None, theme: str | None = None) -> None:
        """Changes the size of the page in pixels, or what it is told of the user's theme."""
        if size is not None:
            self._cdp(
                'Emulation.setDeviceMetricsOverride',
                width=size[0], height=size[1], deviceScaleFactor=1, mobile=False,
            )  # fmt: skip
        if theme is not None:
            features = [{'name': 'prefers-color-scheme', 'value': theme}]
            self._cdp('Emulation.setEmulatedMedia', features=features)

    def offline(self, is_offline: bool) -> None:
        self._cdp('Network.enable')
        self._cdp(
            'Network.emulateNetworkConditions',
            offline=is_offline, latency=0, downloadThroughput=-1, uploadThroughput=-1,
        )  # fmt: skip

    def _cdp(self, command: str, **arguments: Any) -> Any:
        return self.driver.execute_cdp_cmd(command, arguments)

    def find(self, selector: str) -> Any:
        return self.driver.find_element('css selector', selector)

    def find_all(self, selector: str) -> list[Any]:
        return self.driver.find_elements('css selector', selector)

    def run(self, script: str, *arguments: Any) -> Any:
        return self.driver.execute_script(script, *arguments)

    def wait(self, script: str, what: str, timeout_sec: float = WAIT_SEC) -> Any:
        """Waits until a JavaScript expression holds; gives its value."""
        from selenium.common.exceptions import TimeoutException
        from selenium.webdriver.support.ui import WebDriverWait

        try:
            return WebDriverWait(self.driver, timeout_sec, 0.05).until(
                lambda driver: driver.execute_script(f'return {script}')
            )
        except TimeoutException:
            text = self.run('return document.body ? document.body.innerText : ""')
            pytest.fail(f'{what} did not come within {timeout_sec:g} s; {self.console()}\n{text}')

    def type(self, selector: str, text: str) -> None:
        field = self.find(selector)
        field.clear()
        field.send_keys(text)

    def choose(self, selector: str, value: str) -> None:
        from selenium.webdriver.support.ui import Select

        Select(self.find(selector)).select_by_value(value)

    def click(self, selector: str) -> None:
        element = self.find(selector)
        self.run('arguments[0].scrollIntoView({block: "center"})', element)
        element.click()

    def console(self) -> list[str]:
        """What the page said or was refused since the last call.

        Without what the driver says of slow reading: it is a test that reads the pixels.
        """
        messages = [entry['message'] for entry in self.driver.get_log('browser')]
        return [text for text in messages if 'GL Driver Message' not in text]

    def picture(self, path: Path, *, whole: bool = True) -> Path:
        """A screenshot as PNG, of the whole page or of what the window shows."""
        import base64

        shot = self._cdp('Page.captureScreenshot', format='png', captureBeyondViewport=whole)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(base64.b64decode(shot['data']))
        return path

    def colours(self, selector: str) -> int:
        """How many different colours a canvas shows: one where nothing was drawn."""
        return self.run(
            """const source = document.querySelector(arguments[0]);
            const copy = document.createElement('canvas');
            [copy.width, copy.height] = [source.width, source.height];
            const context = copy.getContext('2d');
            context.drawImage(source, 0, 0);
            const pixels = new Uint32Array(
              context.getImageData(0, 0, copy.width, copy.height).data.buffer);
            return new Set(pixels).size;""",
            selector,
        )

    def overflow(self) -> int:
        """By how many pixels the page is wider than the window; 0 is good."""
        page = 'document.documentElement'
        return self.run(f'return Math.max(0, {page}.scrollWidth - {page}.clientWidth)')

    def close(self) -> None:
        with contextlib.suppress(Exception):
            self.driver.quit()


def reason_to_skip() -> str | None:
    """Why no browser can be driven here; None when it can."""
    if BROWSER is None or DRIVER is None:
        return 'needs chromium and chromedriver (apt-get install chromium chromium-driver)'
    try:
        import selenium  # noqa: F401
    except ImportError:
        return 'needs selenium (requirements-dev.txt)'
    return None


@contextlib.contextmanager
def running_browser(profile: Path) -> Iterator[Browser]:
    browser = Browser(profile)
    try:
        yield browser
    finally:
        browser.close()
