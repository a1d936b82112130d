import pytest

from .recorded import record


@pytest.fixture(scope='package')
def recorded(tmp_path_factory):
    """Folder with ``bag``, ``models`` and ``w.safetensors``; the can is lost in the last cloud."""
    folder = tmp_path_factory.mktemp('replay')
    record(folder)
    return folder
