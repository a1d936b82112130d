"""Splits over scenes, and splits over objects."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from spatial_relations_ros.core import Relation
from spatial_relations_ros.datasets.freiburg import Split

NUM_GROUPS = 6
_OBJECTS_PER_GROUP = 24
_TEST_SHARE = 0.25


def num_groups(num_objects: int) -> int:
    """How many groups objects are dealt to; scenes pair objects of one group only.

    Six groups give 15 splits with two of them held out. Small sets get fewer groups, since each
    needs containers and things that fit in.
    """
    return max(1, min(NUM_GROUPS, num_objects // _OBJECTS_PER_GROUP))


def group_of(object_idx: int, *, num_families: int, groups: int) -> int:
    """Group of an object; families are numbered round robin and spread over all groups."""
    return (object_idx % num_families + object_idx // num_families) % groups


def scene_splits(
    names: Sequence[str],
    labels: Sequence[Relation],
    *,
    num_splits: int,
    rng: np.random.Generator,
) -> tuple[Split, ...]:
    """Random splits over scenes, a quarter of each label for testing."""
    splits = []
    for number in range(1, num_splits + 1):
        is_test = np.zeros(len(names), dtype=bool)
        for relation in Relation:
            members = np.flatnonzero(np.asarray(labels, dtype=np.int64) == int(relation))
            count = round(_TEST_SHARE * len(members))
            is_test[rng.permutation(members)[:count]] = True
        splits.append(_split(f'split{number}', names, is_test))
    return tuple(splits)


def object_splits(
    names: Sequence[str], group_idx: Sequence[int], *, groups: int, num_splits: int
) -> tuple[Split, ...]:
    """Splits that hold out whole groups of objects: about a third of them."""
    if groups < 2:
        return ()
    held_out = list(itertools.combinations(range(groups), max(1, groups // 3)))
    splits = []
    for number, test_groups in enumerate(held_out[:num_splits], start=1):
        is_test = np.isin(np.asarray(group_idx), test_groups)
        splits.append(_split(f'split{number}', names, is_test))
    return tuple(splits)


def _split(name: str, names: Sequence[str], is_test: np.ndarray) -> Split:
    return Split(
        name,
        tuple(scene for scene, test in zip(names, is_test, strict=True) if not test),
        tuple(scene for scene, test in zip(names, is_test, strict=True) if test),
    )
