import itertools

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from spatial_relations_ros.learning import (
    all_pairs_contrastive_loss,
    euclidean_distance,
    triplet_contrastive_loss,
)


def embeddings(num, seed, dim=5):
    generator = torch.Generator().manual_seed(seed)
    return torch.randn(num, dim, generator=generator, dtype=torch.float64) * 0.5


@given(st.integers(0, 50))
def test_triplet_loss_equals_the_formula_of_the_paper(seed):
    anchor, positive, negative = embeddings(12, seed).reshape(3, 4, 5)
    total = 0.0
    for a, p, n in zip(anchor, positive, negative, strict=True):
        d_plus = sum((a - p) ** 2) ** 0.5
        d_minus = sum((a - n) ** 2) ** 0.5
        total += 0.5 * d_plus**2 + 0.5 * max(0.0, 1.0 - d_minus) ** 2
    loss = triplet_contrastive_loss(anchor, positive, negative)
    assert float(loss) == pytest.approx(float(total) / 4)


@given(st.integers(0, 50))
def test_all_pairs_loss_equals_a_naive_double_loop(seed):
    vectors = embeddings(9, seed)
    labels = torch.tensor([0, 0, 0, 1, 1, 2, 2, 2, 3])
    pull, push = [], []
    for i, j in itertools.combinations(range(9), 2):
        distance = float((vectors[i] - vectors[j]).norm())
        if labels[i] == labels[j]:
            pull.append(distance**2)
        elif distance < 1.0:
            push.append((1.0 - distance) ** 2)
    expected = 0.5 * (sum(pull) / len(pull) + (sum(push) / len(push) if push else 0.0))
    assert float(all_pairs_contrastive_loss(vectors, labels)) == pytest.approx(expected)


def test_a_batch_without_pairs_has_zero_loss_and_a_gradient():
    vector = embeddings(1, 0).requires_grad_(True)
    loss = all_pairs_contrastive_loss(vector, torch.tensor([2]))
    loss.backward()
    assert float(loss.detach()) == 0.0
    assert torch.equal(vector.grad, torch.zeros_like(vector))


def test_identical_scenes_have_a_finite_gradient():
    first = embeddings(3, 0).requires_grad_(True)
    euclidean_distance(first, first.detach().clone()).sum().backward()
    assert torch.isfinite(first.grad).all()
    assert float(euclidean_distance(first, first)[0]) <= 1e-6


def test_gradients_of_the_losses_equal_finite_differences():
    labels = torch.tensor([0, 0, 1, 1, 2])
    vectors = embeddings(5, 3).requires_grad_(True)
    assert torch.autograd.gradcheck(lambda v: all_pairs_contrastive_loss(v, labels), vectors)
    parts = embeddings(6, 4).reshape(3, 2, 5).requires_grad_(True)
    assert torch.autograd.gradcheck(lambda p: triplet_contrastive_loss(*p), parts)
