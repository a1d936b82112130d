import re

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.visualization import terminal_picture


def test_two_pixels_stand_above_each_other_in_each_character():
    image = np.zeros((40, 80, 3), dtype=np.uint8)
    image[:20] = (255, 10, 20)
    lines = terminal_picture(image, columns=8).splitlines()
    assert len(lines) == 2
    assert [len(re.sub(r'\x1b\[[\d;]*m', '', line)) for line in lines] == [8, 8]
    assert '38;2;255;10;20;48;2;255;10;20' in lines[0]
    assert '38;2;0;0;0;48;2;0;0;0' in lines[1]
    with pytest.raises(ConfigError, match='columns'):
        terminal_picture(image, columns=0)
