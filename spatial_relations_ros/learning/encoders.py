"""G_W: networks that map the three depth images of a scene to an embedding."""

from __future__ import annotations

import copy
import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Callable

import torch
import torch.nn.functional as F
from torch import Tensor, nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.projection import PLANES, ProjectionConfig

EMBEDDING_DIM = 64


class Encoder(nn.Module, ABC):
    """Base of all encoders: one sub-network for all planes, then layers that fuse the planes.

    Subclasses set ``projection`` (the images they expect), ``value_scale`` and ``fuse`` (from the
    features of all planes, (B, F), to embeddings), and implement :meth:`features`.
    """

    projection: ProjectionConfig
    value_scale: float
    fuse: nn.Module

    @abstractmethod
    def features(self, images: Tensor) -> Tensor:
        """Features of single planes, (B, 2, S, S) to (B, ...)."""

    def forward(self, images: Tensor) -> Tensor:
        """Embeddings (B, 64) of images (B, 3, 2, S, S) with values as ``project`` gives them."""
        batch = images.shape[0]
        planes = (images / self.value_scale).flatten(0, 1)
        planes = planes.contiguous(memory_format=torch.channels_last)
        features = self.features(planes).contiguous().view(batch, -1)
        embeddings: Tensor = self.fuse(features)
        return embeddings

    def for_inference(self) -> Encoder:
        """A copy in evaluation mode whose weights take no gradient, as fast as it can be."""
        return copy.deepcopy(self).eval().requires_grad_(False)


class Jund2018(Encoder):
    """The network of Jund et al., ICRA 2018, figure 4 (1.107 M parameters).

    Convolutions of stride one with SAME padding, ELU; the first five are followed by 2 x 2 max
    pooling (SAME: odd sizes are rounded up). Dropout 0.5 on the fully connected layer's input.
    """

    projection = ProjectionConfig(image_size=100, margin_px=1.0, splat_px=5, gradient='sobel')
    value_scale = 255.0
    _LAYERS = (  # kernel, channels, pool
        (10, 32, True),
        (8, 42, True),
        (6, 64, True),
        (4, 64, True),
        (4, 128, True),
        (4, 128, False),
        (2, 128, False),
    )

    def __init__(self) -> None:
        super().__init__()
        channels = 2
        convolutions = []
        for kernel, width, _ in self._LAYERS:
            convolutions.append(nn.Conv2d(channels, width, kernel))
            channels = width
        self.convolutions = nn.ModuleList(convolutions)
        self.fuse = nn.Sequential(
            nn.Dropout(0.5), nn.Linear(len(PLANES) * channels * 4 * 4, EMBEDDING_DIM)
        )

    def features(self, images: Tensor) -> Tensor:
        """See the base class."""
        for convolution, (kernel, _, pool) in zip(self.convolutions, self._LAYERS, strict=True):
            before, after = (kernel - 1) // 2, kernel // 2
            images = F.elu(convolution(F.pad(images, (before, after, before, after))))
            if pool:
                images = F.max_pool2d(images, 2, ceil_mode=True)
        return images


class Jund2018Released(Jund2018):
    """The same network as the authors' released code uses it.

    Images lose the data's mean, here a running mean over the batches of training, and the
    embedding passes an ELU.
    """

    projection = dataclasses.replace(Jund2018.projection, gradient='released')
    running_mean: Tensor
    _MOMENTUM = 0.01

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer('running_mean', torch.zeros(2, 1, 1))

    def forward(self, images: Tensor) -> Tensor:
        """See the base class."""
        if self.training:
            mean = images.detach().mean(dim=(0, 1, 3, 4))[:, None, None]
            self.running_mean.lerp_(mean, self._MOMENTUM)
        return F.elu(super().forward(images - self.running_mean))


class Compact(Encoder):
    """A small strided network on 64-pixel images, for CPUs.

    Each plane's features are reduced to a vector and two layers fuse the three: on the same data
    that gave far better retrieval than one linear layer over all features.
    """

    projection = ProjectionConfig(image_size=64, margin_px=1.0, splat_px=3)
    value_scale = 100.0
    _LAYERS = (  # kernel, channels, stride
        (5, 24, 2),
        (3, 48, 2),
        (3, 96, 2),
        (3, 96, 1),
        (3, 128, 2),
        (3, 128, 1),
    )
    _PLANE_FEATURES, _FUSED_FEATURES = 128, 256

    def __init__(self) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        channels = 2
        for kernel, width, stride in self._LAYERS:
            layers += [
                nn.Conv2d(channels, width, kernel, stride, kernel // 2, bias=False),
                nn.BatchNorm2d(width),
                nn.ELU(),
            ]
            channels = width
        self.layers = nn.Sequential(*layers)
        self.reduce = nn.Sequential(nn.Linear(channels * 4 * 4, self._PLANE_FEATURES), nn.ELU())
        self.fuse = nn.Sequential(
            nn.Dropout(0.1),
            nn.Linear(len(PLANES) * self._PLANE_FEATURES, self._FUSED_FEATURES, bias=False),
            nn.BatchNorm1d(self._FUSED_FEATURES),
            nn.ELU(),
            nn.Linear(self._FUSED_FEATURES, EMBEDDING_DIM),
        )

    def features(self, images: Tensor) -> Tensor:
        """See the base class."""
        features: Tensor = self.reduce(self.layers(images).flatten(1))
        return features

    def for_inference(self) -> Compact:
        """See the base class; normalisation becomes part of the convolution before it."""
        encoder = copy.deepcopy(self).eval()
        layers = encoder.layers
        for idx in range(0, len(layers), 3):
            convolution, normalisation = layers[idx], layers[idx + 1]
            assert isinstance(convolution, nn.Conv2d)
            assert isinstance(normalisation, nn.BatchNorm2d)
            layers[idx] = fuse_conv_bn_eval(convolution, normalisation)
            layers[idx + 1] = nn.Identity()
        return encoder.requires_grad_(False)


ENCODERS: dict[str, Callable[[], Encoder]] = {
    'compact': Compact,
    'jund2018': Jund2018,
    'jund2018_released': Jund2018Released,
}


def make_encoder(name: str) -> Encoder:
    """A new encoder with random weights.

    Raises:
        ConfigError: for an unknown name.
    """
    try:
        return ENCODERS[name]()
    except KeyError:
        known = ', '.join(sorted(ENCODERS))
        raise ConfigError(f'no encoder is called {name!r}; there are {known}') from None
