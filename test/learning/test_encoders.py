import pytest
import torch

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.learning import EMBEDDING_DIM, ENCODERS, Jund2018, make_encoder


def images(encoder, batch=2):
    size = encoder.projection.image_size
    generator = torch.Generator().manual_seed(0)
    values = 100.0 + 100.0 * torch.rand(batch, 3, 2, size, size, generator=generator)
    return values * (torch.rand(values.shape, generator=generator) > 0.5)


@pytest.mark.parametrize('name', sorted(ENCODERS))
def test_an_encoder_maps_images_to_embeddings(name):
    encoder = make_encoder(name).eval()
    embeddings = encoder(images(encoder))
    assert embeddings.shape == (2, EMBEDDING_DIM)
    assert torch.isfinite(embeddings).all()
    assert not torch.allclose(embeddings[0], embeddings[1])


def test_jund2018_is_the_network_of_the_paper():
    encoder = Jund2018()
    shapes = [tuple(layer.weight.shape) for layer in encoder.convolutions]
    assert shapes == [
        (32, 2, 10, 10),
        (42, 32, 8, 8),
        (64, 42, 6, 6),
        (64, 64, 4, 4),
        (128, 64, 4, 4),
        (128, 128, 4, 4),
        (128, 128, 2, 2),
    ]
    dropout, fuse = encoder.fuse
    assert fuse.weight.shape == (64, 3 * 4 * 4 * 128)
    assert dropout.p == 0.5
    assert sum(p.numel() for p in encoder.parameters()) == 1_107_338
    features = encoder.features(torch.zeros(1, 2, 100, 100))
    assert features.shape == (1, 128, 4, 4)  # 100, 50, 25, 13, 7, 4: SAME pooling rounds up


def test_planes_share_the_convolutions_but_not_the_fusion():
    encoder = make_encoder('compact').eval()
    batch = images(encoder, batch=1)
    swapped = encoder(batch[:, [1, 0, 2]])
    assert not torch.allclose(encoder(batch), swapped)
    features = encoder.features(batch[0] / encoder.value_scale)
    again = encoder.features(batch[0, [1, 0, 2]] / encoder.value_scale)
    assert torch.allclose(features[[1, 0, 2]], again, atol=1e-5)


def test_an_unknown_encoder_names_the_known_ones():
    with pytest.raises(ConfigError, match='compact, jund2018'):
        make_encoder('resnet')


@pytest.mark.parametrize('name', sorted(ENCODERS))
def test_the_copy_for_inference_computes_the_same(name):
    encoder = make_encoder(name)
    size = encoder.projection.image_size
    batch = torch.rand(6, 3, 2, size, size) * 200.0
    encoder.train()
    encoder(batch)  # running statistics that are not the initial ones
    fast = encoder.for_inference()
    encoder.eval()
    torch.testing.assert_close(fast(batch), encoder(batch), atol=1e-4, rtol=1e-4)
    assert not fast.training
    assert not any(parameter.requires_grad for parameter in fast.parameters())
    assert all(parameter.requires_grad for parameter in encoder.parameters())
