"""Reading the continuous ground truth beside the labels."""

import contextlib
import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from spatial_relations_ros.core import DatasetFormatError, Relation
from spatial_relations_ros.datasets.ground_truth import MEASURES, read_measures


def truth(name, relation, **fields):
    values = {'lean_rad': 0.4, 'overhang_share': 0.3, 'clearance': 0.02, 'extent': 0.4}
    values |= {'depth_share': 0.7, **fields}
    return json.dumps({'scene': name, 'relation': int(relation), **values})


def write(folder, *lines):
    (folder / 'ground_truth.jsonl').write_text('\n'.join(lines))


def test_only_measures_that_say_something_of_the_relation_are_known(tmp_path):
    write(
        tmp_path,
        truth('a', Relation.NEXT_TO),
        truth('b', Relation.INCLINED),
        truth('c', Relation.ON_TOP_EDGE),
        truth('d', Relation.INSIDE_LYING, depth_share=None),
        truth('e', Relation.ON_TOP),
    )
    measures = read_measures(tmp_path, ['e', 'd', 'c', 'b', 'a', 'unknown'])
    assert measures.shape == (6, len(MEASURES))
    lean, overhang, gap, depth = measures.T
    np.testing.assert_allclose(gap[4], 2 * 0.02 / 0.4, rtol=1e-6)
    np.testing.assert_allclose(lean[[1, 3]], 0.4 / (np.pi / 4), rtol=1e-6)
    np.testing.assert_allclose(overhang[2], 0.3, rtol=1e-6)
    assert np.isnan(depth).all()
    assert np.isnan(measures[[0, 5]]).all()


def test_a_dataset_without_the_file_has_no_measures(tmp_path):
    assert read_measures(tmp_path, ['a']) is None


@pytest.mark.parametrize(
    'line',
    [
        '{',
        '[]',
        '{"scene": "a"}',
        truth('a', 3, extent='wide'),
        truth('a', 3, extent=0),
        truth('a', 3, lean_rad=10**400),
        truth('a', 9),
    ],
)
def test_a_damaged_line_is_named(tmp_path, line):
    write(tmp_path, truth('first', Relation.INSIDE), line)
    with pytest.raises(DatasetFormatError, match='line 2'):
        read_measures(tmp_path, ['first'])


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(content=st.binary(max_size=200))
def test_any_bytes_give_measures_or_a_named_error(tmp_path, content):
    (tmp_path / 'ground_truth.jsonl').write_bytes(content)
    with contextlib.suppress(DatasetFormatError):
        assert read_measures(tmp_path, ['a']).shape == (1, len(MEASURES))
