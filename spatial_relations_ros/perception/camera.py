"""The camera behind an organised cloud."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.perception.point_cloud2 import PointCloud

FIT_STRIDE = 8
MIN_FIT_PIXELS = 50
MAX_FIT_ERROR_PX = 0.5


@dataclass(frozen=True)
class PinholeCamera:
    """A camera without distortion; optical frame: x right, y down, z forward.

    Attributes:
        width: columns of the image.
        height: rows of the image.
        fx: focal length along x, pixels.
        fy: focal length along y, pixels.
        cx: column of the optical axis; the centre of the first pixel is 0.
        cy: row of the optical axis.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def project(self, points: NDArray[np.floating]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Nearest column and row (N,) of points (N, 3) in front of the camera, z > 0.

        Points far outside of the image are moved to a pixel that is also far outside.
        """
        with np.errstate(over='ignore'):
            column = self.fx * points[:, 0] / points[:, 2] + self.cx
            row = self.fy * points[:, 1] / points[:, 2] + self.cy
        far = 10 * max(self.width, self.height)
        return (
            np.rint(np.clip(column, -far, far)).astype(np.intp),
            np.rint(np.clip(row, -far, far)).astype(np.intp),
        )

    def rays(self) -> NDArray[np.float32]:
        """(H, W, 3) directions of the pixels, scaled to z = 1."""
        column, row = np.meshgrid(np.arange(self.width), np.arange(self.height))
        x, y = (column - self.cx) / self.fx, (row - self.cy) / self.fy
        return np.stack([x, y, np.ones_like(x)], axis=-1).astype(np.float32)


def estimate_camera(cloud: PointCloud) -> PinholeCamera | None:
    """Finds the pinhole camera that a cloud was made with.

    A PointCloud2 does not tell its camera, but an organised one gives it away: column and row of
    each point are linear in x/z and y/z.

    Returns:
        The camera, or None when the cloud is not the image of a pinhole camera.
    """
    if not cloud.is_organised:
        return None
    thin = cloud.decimated(FIT_STRIDE)
    rows, columns = np.nonzero(thin.finite & (thin.xyz[..., 2] > 0.0))
    if len(rows) < MIN_FIT_PIXELS:
        return None
    points = thin.xyz[rows, columns].astype(np.float64)
    with np.errstate(over='ignore', invalid='ignore'):
        fit_x = _fit_line(points[:, 0] / points[:, 2], FIT_STRIDE * columns)
        fit_y = _fit_line(points[:, 1] / points[:, 2], FIT_STRIDE * rows)
    if fit_x is None or fit_y is None:
        return None
    height, width = cloud.xyz.shape[:2]
    return PinholeCamera(width, height, fit_x[0], fit_y[0], fit_x[1], fit_y[1])


def _fit_line(tangent: NDArray[np.float64], pixel: NDArray[np.intp]) -> tuple[float, float] | None:
    """``(focal, centre)`` of ``pixel = focal * tangent + centre``, or None if it is no line."""
    mean_tangent, mean_pixel = tangent.mean(), pixel.mean()
    spread = tangent - mean_tangent
    variance = float(spread @ spread)
    if not 0.0 < variance < np.inf:
        return None
    focal = float(spread @ (pixel - mean_pixel)) / variance
    error = np.abs(focal * spread - (pixel - mean_pixel))
    num_outliers = np.count_nonzero(error > MAX_FIT_ERROR_PX)
    if not focal > 0.0 or num_outliers > 0.01 * len(error):
        return None
    return focal, float(mean_pixel - focal * mean_tangent)
