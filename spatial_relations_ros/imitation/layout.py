"""How far beside each other two objects are, whatever their sizes."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

# Farther apart, in metres, than this things are not next to each other, however large they are.
MAX_GAP = 0.16
_BESIDE = 0.9
_LOW = 0.15
_OVER_BORDER = 0.05
# Half of this, in the spacing, is another place.
_OTHER_PLACE = 0.6
_TINY = 1e-6


@dataclass(frozen=True)
class Layout:
    """Where objects are beside, on or in each other, seen from above; each (K,).

    Attributes:
        spacing: horizontal distance of their middles over the sum of their half widths: 0 where
            one is in the middle of the other, 1 where they touch side by side, more with a gap.
            Widths are taken along the line between the middles.
        spacing_within: at which the smaller one reaches the larger one's border from within.
        half_widths: their sum, metres.
        is_low: whether the relative reaches down about as far as the base does.
    """

    spacing: Tensor
    spacing_within: Tensor
    half_widths: Tensor
    is_low: Tensor

    @staticmethod
    def of(points: Tensor) -> Layout:
        """The layout of clouds (K, 2, N, 3) of base and relative, metres, z up."""
        flat = points[..., :2]
        middles = 0.5 * (flat.amin(dim=2) + flat.amax(dim=2))
        offset = middles[:, 1] - middles[:, 0]
        distance = offset.norm(dim=-1)
        direction = offset / distance.clamp_min(_TINY)[:, None]
        # Of objects right above each other any line will do.
        centred = (distance < _TINY)[:, None]
        direction = torch.where(centred, torch.tensor([1.0, 0.0]), direction)
        along = (flat * direction[:, None, None]).sum(dim=-1)
        half_widths = 0.5 * (along.amax(dim=2) - along.amin(dim=2)).clamp_min(_TINY)
        total = half_widths.sum(dim=1)
        within = (half_widths.amax(dim=1) - half_widths.amin(dim=1)) / total
        lowest, heights = points[..., 2].amin(dim=2), points[..., 2].amax(dim=2)
        is_low = lowest[:, 1] - lowest[:, 0] < _LOW * (heights[:, 0] - lowest[:, 0])
        return Layout(distance / total, within, total, is_low)

    @property
    def is_beside(self) -> bool:
        """Whether the first of these stands beside its base, round the corner of it perhaps."""
        spacing = float(self.spacing[0])
        over_border = spacing > float(self.spacing_within[0]) + _OVER_BORDER
        return spacing >= _BESIDE or (bool(self.is_low[0]) and over_border)

    def difference(self, wanted: Layout) -> Tensor:
        """How far these layouts (K,) are from another one; a half is another place.

        Beside each other the spacing counts, in shares of the wanted one, as far as the gap
        remains that of neighbours; on or in each other the smaller one goes no farther out than
        to the larger one's border.
        """
        if not wanted.is_beside:
            place = torch.minimum(self.spacing_within, wanted.spacing)
            return ((self.spacing - place).abs() / _OTHER_PLACE).clamp(max=1.0)
        spacing = torch.minimum(1.0 + MAX_GAP / self.half_widths, wanted.spacing)
        return (self.spacing - spacing).abs() / (_OTHER_PLACE * spacing.clamp_min(1.0))
