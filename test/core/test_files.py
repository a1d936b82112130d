import pytest

from spatial_relations_ros.core import ConfigError, atomic_write, share_path


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / 'result.json'
    path.write_text('old')

    def write_half():
        with atomic_write(path) as temporary:
            temporary.write_text('half')
            raise RuntimeError

    with pytest.raises(RuntimeError):
        write_half()
    assert path.read_text() == 'old'
    assert [entry.name for entry in tmp_path.iterdir()] == ['result.json']


def test_a_write_replaces_the_file_and_makes_folders(tmp_path):
    path = tmp_path / 'new' / 'result.json'
    with atomic_write(path) as temporary:
        temporary.write_text('whole')
    assert path.read_text() == 'whole'


def test_shared_files_are_found_in_the_checkout():
    assert share_path('package.xml').is_file()


def test_a_missing_shared_file_says_where_it_was_searched():
    with pytest.raises(ConfigError, match=r'models/none\.bin is not installed; searched'):
        share_path('models', 'none.bin')
