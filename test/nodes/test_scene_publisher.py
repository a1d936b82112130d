"""How often scenes are published."""

from __future__ import annotations

import numpy as np
import pytest

from spatial_relations_ros.nodes.scene_publisher import RateLimit

pytestmark = pytest.mark.ros


def passed(stamps_sec: np.ndarray, rate: float) -> int:
    limit = RateLimit()
    return sum(limit.is_due(float(stamp), rate) for stamp in stamps_sec)


def test_no_cloud_of_a_jittering_sensor_at_the_rate_itself_is_left_out() -> None:
    rng = np.random.default_rng(0)
    stamps_sec = 100.0 + np.arange(600) / 30.0 + rng.uniform(-0.004, 0.004, 600)
    assert passed(stamps_sec, 30.0) == 600


@pytest.mark.parametrize('rate', [2.0, 5.0, 10.0])
def test_a_lower_rate_is_kept_on_average(rate: float) -> None:
    stamps_sec = 100.0 + np.arange(0, 20.0, 1.0 / 30.0)
    assert passed(stamps_sec, rate) == pytest.approx(20.0 * rate, abs=0.05 * 20.0 * rate + 1)
