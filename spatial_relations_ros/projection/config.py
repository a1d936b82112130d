"""What a projection looks like."""

from __future__ import annotations

from dataclasses import dataclass

from spatial_relations_ros.core import ConfigError

DEPTH_SCALE = 100.0
OBJECT_BIAS = 100.0
PLANES = ('top', 'front', 'side')
GRADIENTS = ('silhouette', 'sobel', 'released', 'soft', 'straight_through')


@dataclass(frozen=True)
class ProjectionConfig:
    """Settings of rho, the projection to three depth images.

    Attributes:
        image_size: pixels along an image's side.
        margin_px: pixels that stay free around the scene.
        splat_px: side of the square that a point covers, in pixels, odd. One is the paper's
            projection, meant for clouds sampled every millimetre; sparser clouds need more to
            give solid images.
        gradient: ``silhouette``, ``sobel`` (the paper's), ``released`` (the released code's),
            ``soft`` or ``straight_through``; see
            :mod:`spatial_relations_ros.projection.depth_images`. ``soft`` changes the images too.
        sobel_size: side of the derivative kernel of ``sobel`` and ``released``, in pixels, odd.
        soft_width_px: standard deviation of the blur of the soft projection, in pixels; from
            how far away a point feels a pixel.

    Raises:
        ConfigError: for values that make no image.
    """

    image_size: int = 100
    margin_px: float = 1.0
    splat_px: int = 3
    gradient: str = 'silhouette'
    sobel_size: int = 5
    soft_width_px: float = 1.0

    def __post_init__(self) -> None:
        if self.image_size < 8:
            raise ConfigError(f'image_size is {self.image_size}; at least 8 pixels are needed')
        if not 0.0 <= 2.0 * self.margin_px < self.image_size:
            raise ConfigError(f'margin_px {self.margin_px} leaves no room in {self.image_size} px')
        if self.gradient not in GRADIENTS:
            raise ConfigError(f'gradient is {self.gradient!r}; expected one of {GRADIENTS}')
        for name in ('splat_px', 'sobel_size'):
            value = getattr(self, name)
            if value < 1 or value % 2 == 0:
                raise ConfigError(f'{name} is {value}; it must be odd and positive')
        if self.sobel_size < 3:
            raise ConfigError('sobel_size is 1; a derivative needs at least 3 pixels')
        if not 0.1 <= self.soft_width_px <= self.image_size:
            raise ConfigError(
                f'soft_width_px is {self.soft_width_px}; expected 0.1 to {self.image_size} pixels'
            )
