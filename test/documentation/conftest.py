import os
from pathlib import Path

import pytest
from pages import ROOT

# What a checkout holds, for commands that are run in its root.
CHECKOUT = ('bags', 'config', 'docs', 'examples', 'launch', 'models', 'test')


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A folder that looks like a fresh checkout, as the working directory; home is empty."""
    for name in CHECKOUT:
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('HOME', str(tmp_path / 'home'))
    monkeypatch.setenv('XDG_DATA_HOME', str(tmp_path / 'home' / 'share'))
    monkeypatch.setenv('COLUMNS', '200')
    before = dict(os.environ)
    yield Path(tmp_path)
    os.environ.clear()
    os.environ.update(before)
