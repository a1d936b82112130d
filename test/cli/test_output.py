import json
import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from spatial_relations_ros.cli.output import json_text

values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=20,
)  # fmt: skip


@given(content=st.dictionaries(st.text(), values, max_size=4))
def test_json_says_the_same_after_reading(content):
    assert json.loads(json_text(content)) == content


def test_arrays_become_lists_on_one_line():
    text = json_text({'embedding': np.array([1.0, 0.5], dtype=np.float32), 'ids': ('a', 'b')})
    assert '"embedding": [1.0, 0.5]' in text
    assert '"ids": ["a", "b"]' in text


def test_numbers_that_json_lacks_become_null():
    text = json_text(
        {'values': [math.nan, math.inf, np.float32(1.0)], 'one': np.float64(math.nan)}
    )
    assert json.loads(text) == {'values': [None, None, 1.0], 'one': None}
