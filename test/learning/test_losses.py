import itertools
import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from spatial_relations_ros.learning.losses import (
    RatioLoss,
    all_pairs_contrastive_loss,
    euclidean_distance,
    graded_loss,
    neighbourhood_loss,
    triplet_contrastive_loss,
)
from spatial_relations_ros.learning.multi_similarity import MultiSimilarity


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


@given(st.integers(0, 30))
def test_neighbourhood_loss_equals_a_naive_double_loop(seed):
    vectors = embeddings(7, seed)
    labels = [0, 0, 0, 1, 1, 2, 3]
    total, pairs = 0.0, 0
    for i in range(7):
        weights = [float(torch.exp(-((vectors[i] - v) ** 2).sum() / 0.3)) for v in vectors]
        for j in range(7):
            if i != j and labels[i] == labels[j]:
                total -= math.log(weights[j] / (sum(weights) - weights[i]))
                pairs += 1
    loss = neighbourhood_loss(vectors, torch.tensor(labels))
    assert float(loss) == pytest.approx(total / pairs)


@pytest.mark.parametrize('seed', [0, 1, 2])
def test_multi_similarity_loss_equals_a_naive_loop(seed):
    torch.manual_seed(seed)
    vectors = 0.5 * torch.randn(9, 3, dtype=torch.float64)
    labels = [0, 0, 1, 1, 1, 2, 2, -1, -2]
    total = 0.0
    for i in range(9):
        apart = {j: float((vectors[i] - vectors[j]).norm()) for j in range(9) if j != i}
        alike = {j: d for j, d in apart.items() if labels[j] == labels[i]}
        unlike = {j: d for j, d in apart.items() if labels[j] != labels[i]}
        hardest = max(alike.values(), default=-math.inf), min(unlike.values())
        pulled = [d for d in alike.values() if d > hardest[1] - 0.1]
        pushed = [d for d in unlike.values() if d < hardest[0] + 0.1]
        total += math.log1p(sum(math.exp(2.0 * (d - 0.6)) for d in pulled)) / 2.0
        total += math.log1p(sum(math.exp(10.0 * (0.6 - d)) for d in pushed)) / 10.0
    loss = MultiSimilarity()(vectors, torch.tensor(labels))
    assert float(loss) == pytest.approx(total / 9, rel=1e-6)


def test_multi_similarity_loss_of_scenes_without_a_pair_is_zero_with_a_gradient():
    vectors = torch.zeros(2, 3, requires_grad=True)
    loss = MultiSimilarity()(vectors, torch.tensor([0, 1]))
    loss.backward()
    assert float(loss.detach()) == 0.0
    assert vectors.grad is not None


def test_graded_loss_wants_distances_in_proportion_to_the_measures():
    measures = torch.tensor([[0.0, 0.0], [0.3, 0.4], [9.0, 0.0], [0.0, 0.0]])
    labels = torch.tensor([1, 1, 1, 2])
    # Half a unit apart lies half the reach apart; far apart is cut at the reach.
    kept = torch.tensor([[0.0, 0.0], [0.2, 0.0], [0.1, math.sqrt(0.16 - 0.01)], [5.0, 5.0]])
    assert float(graded_loss(kept, labels, measures, reach=0.4)) == pytest.approx(0.0, abs=1e-12)
    together = torch.zeros(4, 2)
    expected = (0.2**2 + 0.4**2 + 0.4**2) / 3
    assert float(graded_loss(together, labels, measures, reach=0.4)) == pytest.approx(
        expected, rel=1e-4
    )


def test_graded_loss_leaves_out_what_is_not_known():
    unknown = torch.full((3, 2), torch.nan)
    vectors = embeddings(3, 0).requires_grad_(True)
    loss = graded_loss(vectors, torch.zeros(3, dtype=torch.long), unknown, reach=0.4)
    loss.backward()
    assert float(loss.detach()) == 0.0
    half_known = torch.tensor([[0.5, torch.nan], [0.0, 1.0], [torch.nan, torch.nan]])
    near = torch.tensor([[0.2, 0.0], [0.0, 0.0], [7.0, 7.0]])
    value = graded_loss(near, torch.zeros(3, dtype=torch.long), half_known, reach=0.4)
    assert float(value) == pytest.approx(0.0, abs=1e-9)


def test_ratio_loss_is_the_squared_softmax_and_does_not_overflow():
    loss = RatioLoss(momentum=1.0)
    anchor = torch.zeros(1, 1)
    value = loss(anchor, torch.tensor([[1.0]]), torch.tensor([[3.0]]))
    assert float(loss.running_mean) == pytest.approx(2.0)
    share = math.exp(0.5) / (math.exp(0.5) + math.exp(1.5))
    assert float(value) == pytest.approx(2.0 * share**2)
    loss.eval()
    far = loss(anchor, torch.tensor([[1e4]]), torch.tensor([[0.0]]))
    assert float(far) == pytest.approx(2.0)


def test_the_gradient_of_all_pairs_repeats_on_two_threads():
    embeddings = torch.randn(84, 64, generator=torch.Generator().manual_seed(0))
    labels = torch.arange(84) % 7
    threads = torch.get_num_threads()
    torch.set_num_threads(2)
    try:
        gradients = set()
        for _ in range(400):
            leaf = embeddings.clone().requires_grad_(True)
            all_pairs_contrastive_loss(leaf, labels).backward()
            gradients.add(leaf.grad.numpy().tobytes())
    finally:
        torch.set_num_threads(threads)
    assert len(gradients) == 1
