import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spatial_relations_ros.core import DatasetFormatError, Relation
from spatial_relations_ros.evaluation.retrieval import evaluate_embeddings


def naive(gallery, gallery_labels, queries, query_labels):
    three = five = 0
    precisions = []
    for query, label in zip(queries, query_labels, strict=True):
        ranked = sorted(range(len(gallery)), key=lambda k: np.linalg.norm(gallery[k] - query))
        matches = [gallery_labels[k] == label for k in ranked]
        three += sum(matches[:5]) >= 3
        five += sum(matches[:5]) == 5
        hits = [sum(matches[: k + 1]) / (k + 1) for k in range(len(ranked)) if matches[k]]
        precisions.append(np.mean(hits) if hits else 0.0)
    return three / len(queries), five / len(queries), np.mean(precisions)


@settings(deadline=None)
@given(st.integers(0, 1000), st.integers(5, 30), st.integers(1, 10))
def test_numbers_equal_a_naive_loop(seed, num_gallery, num_queries):
    rng = np.random.default_rng(seed)
    gallery, queries = rng.normal(size=(num_gallery, 3)), rng.normal(size=(num_queries, 3))
    gallery_labels = rng.integers(0, 3, num_gallery)
    query_labels = rng.integers(0, 3, num_queries)
    result = evaluate_embeddings(gallery, gallery_labels, queries, query_labels)
    three, five, precision = naive(gallery, gallery_labels, queries, query_labels)
    assert result.three_of_five == pytest.approx(three)
    assert result.five_of_five == pytest.approx(five)
    assert result.mean_average_precision == pytest.approx(precision)
    assert result.confusion.sum() == num_queries


def test_perfect_embeddings_score_perfectly_and_random_ones_do_not():
    rng = np.random.default_rng(0)
    labels = np.repeat(np.arange(len(Relation)), 20)
    perfect = np.eye(len(Relation))[labels]
    result = evaluate_embeddings(perfect, labels, perfect, labels)
    assert result.three_of_five == result.five_of_five == result.mean_average_precision == 1.0
    noise = rng.normal(size=perfect.shape)
    result = evaluate_embeddings(noise, labels, rng.normal(size=perfect.shape), labels)
    assert result.three_of_five < 0.2


def test_too_few_scenes_are_told():
    with pytest.raises(DatasetFormatError, match='1 test and 4 training scenes'):
        evaluate_embeddings(np.zeros((4, 2)), np.zeros(4, int), np.zeros((1, 2)), np.zeros(1, int))
