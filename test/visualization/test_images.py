import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.visualization import read_image, write_image


def test_round_trip_keeps_every_pixel(tmp_path):
    image = np.random.default_rng(0).integers(0, 256, (7, 9, 3), dtype=np.uint8)
    path = write_image(tmp_path / 'deep' / 'a.png', image)
    assert np.array_equal(read_image(path), image)
    assert [item.name for item in path.parent.iterdir()] == ['a.png']


def test_refuses_what_is_no_picture(tmp_path):
    image = np.zeros((4, 4, 3), dtype=np.uint8)
    with pytest.raises(ConfigError, match='png'):
        write_image(tmp_path / 'a.jpg', image)
    with pytest.raises(ConfigError, match='uint8'):
        write_image(tmp_path / 'a.png', image.astype(np.float32))
    with pytest.raises(ConfigError, match='not a picture'):
        read_image(tmp_path / 'none.png')


def test_a_failed_write_keeps_the_old_picture(tmp_path):
    path = write_image(tmp_path / 'a.png', np.zeros((4, 4, 3), dtype=np.uint8))
    with pytest.raises(ConfigError):
        write_image(path, np.zeros((0, 4, 3), dtype=np.uint8))
    assert read_image(path).shape == (4, 4, 3)
