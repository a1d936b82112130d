"""Names of pose topics."""

from __future__ import annotations

import pytest

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.perception.pose_topics import pose_topics


def test_an_object_is_named_by_its_topic_or_before_it():
    entries = ['/simtrack/bowl', 'cup_2=/tracker/pose']
    assert pose_topics(entries) == {'bowl': '/simtrack/bowl', 'cup_2': '/tracker/pose'}


@pytest.mark.parametrize('entry', ['/', '=/x', 'cup='])
def test_what_names_nothing_is_refused(entry):
    with pytest.raises(ConfigError, match='pose_topics has'):
        pose_topics([entry])


def test_two_topics_of_one_object_are_refused():
    with pytest.raises(ConfigError, match=r'/bowl/pose and /cup/pose .* "cup=/cup/pose"'):
        pose_topics(['/bowl/pose', '/cup/pose'])
