"""Several pictures on one sheet, with captions."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

from spatial_relations_ros.core import ConfigError, Scene, SceneObject
from spatial_relations_ros.visualization.camera import frame_objects, outline_points
from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.lettering import letter, shortened
from spatial_relations_ros.visualization.palette import (
    BASE_COLOUR,
    FADED_INK,
    PAPER,
    RELATIVE_COLOUR,
    as_bytes,
)
from spatial_relations_ros.visualization.rendering import render_scene

GAP = 14
CAPTION_ROWS = 34
LEGEND_ROWS = 26
MOVED_METRES = 1e-4
MOVED_RAD = 1e-3


def contact_sheet(
    images: Sequence[Image], captions: Sequence[str] = (), *, columns: int | None = None
) -> Image:
    """Pictures in a grid, each with a caption above; smaller ones are scaled to the largest.

    Args:
        images: (H, W, 3) uint8 RGB each, at least one.
        captions: one a picture, or none at all.
        columns: of the grid; about square by default.

    Returns:
        (H, W, 3) uint8 RGB.

    Raises:
        ConfigError: without pictures, or with another number of captions.
    """
    if not images:
        raise ConfigError('a contact sheet needs at least one picture')
    if captions and len(captions) != len(images):
        raise ConfigError(f'{len(images)} pictures have {len(captions)} captions')
    columns = columns or math.ceil(math.sqrt(len(images)))
    columns = min(columns, len(images))
    rows = math.ceil(len(images) / columns)
    height = max(image.shape[0] for image in images)
    width = max(image.shape[1] for image in images)
    head = CAPTION_ROWS if captions else 0
    sheet = np.empty(
        (rows * (height + head + GAP) + GAP, columns * (width + GAP) + GAP, 3), dtype=np.uint8
    )
    sheet[:] = as_bytes(PAPER)
    for idx, image in enumerate(images):
        row = GAP + idx // columns * (height + head + GAP)
        column = GAP + idx % columns * (width + GAP)
        if captions:
            _caption(sheet[row : row + head, column : column + width], captions[idx])
        sheet[row + head : row + head + height, column : column + width] = _fitted(
            image, height, width
        )
    return sheet


def _fitted(image: Image, height: int, width: int) -> Image:
    """The picture scaled to fit, centred on white."""
    if image.shape[:2] == (height, width):
        return image
    factor = min(height / image.shape[0], width / image.shape[1])
    size = max(1, int(image.shape[1] * factor)), max(1, int(image.shape[0] * factor))
    interpolation = cv2.INTER_AREA if factor < 1.0 else cv2.INTER_CUBIC
    scaled = cv2.resize(image, size, interpolation=interpolation)
    cell = np.empty((height, width, 3), dtype=np.uint8)
    cell[:] = as_bytes(PAPER)
    row, column = (height - scaled.shape[0]) // 2, (width - scaled.shape[1]) // 2
    cell[row : row + scaled.shape[0], column : column + scaled.shape[1]] = scaled
    return cell


def _caption(strip: Image, caption: str) -> None:
    text = shortened(caption, strip.shape[1] - 4, size=16, bold=True)
    letter(strip, text, (2, strip.shape[0] / 2 - 2), size=16, bold=True)


def before_after(
    reference: Scene,
    before: Scene,
    after: Scene,
    *,
    table_height: float | None = None,
    captions: tuple[str, str, str] = ('demonstration', 'before', 'after'),
    width: int = 560,
    height: int = 440,
) -> Image:
    """The demonstration, the test scene before and after, beside each other.

    Before and after are seen by the same camera; in the last picture the objects that moved are
    left behind as ghosts.

    Args:
        reference: the demonstrated scene.
        before: the test scene as it stood.
        after: the test scene with the objects at their targets.
        table_height: world z of the table in the test scene; its lowest point before by default.
        captions: above the three pictures.
        width: of each picture, pixels.
        height: of each picture, pixels.

    Returns:
        (H, W, 3) uint8 RGB.
    """
    camera = frame_objects([before.objects, after.objects], width=width, height=height)
    if table_height is None:
        table_height = min(float(outline_points(item)[:, 2].min()) for item in before.objects)
    pictures = [
        render_scene(reference.objects, width=width, height=height),
        render_scene(before.objects, camera=camera, table_height=table_height),
        render_scene(
            after.objects,
            ghosts=moved_objects(before, after),
            camera=camera,
            table_height=table_height,
        ),
    ]
    sheet = contact_sheet(pictures, captions, columns=3)
    legend = np.empty((LEGEND_ROWS, sheet.shape[1], 3), dtype=np.uint8)
    legend[:] = as_bytes(PAPER)
    for idx, scene in enumerate((reference, before, after)):
        _legend(legend, GAP + idx * (width + GAP), scene)
    return np.concatenate([sheet, legend, np.full_like(legend[:GAP], 255)])


def answer_sheet(
    before: Scene,
    answers: Sequence[Scene],
    captions: Sequence[str],
    *,
    table_height: float | None = None,
    width: int = 420,
    height: int = 320,
) -> Image:
    """All answers beside each other, seen by one camera; where objects stood they are ghosts.

    Args:
        before: the test scene as it stood.
        answers: the test scene with the objects at each answer's targets, at least one.
        captions: one an answer.
        table_height: world z of the table; the lowest point before by default.
        width: of each picture, pixels.
        height: of each picture, pixels.

    Returns:
        (H, W, 3) uint8 RGB.

    Raises:
        ConfigError: without answers, or with another number of captions.
    """
    camera = frame_objects(
        [before.objects, *(scene.objects for scene in answers)], width=width, height=height
    )
    if table_height is None:
        table_height = min(float(outline_points(item)[:, 2].min()) for item in before.objects)
    pictures = [
        render_scene(
            scene.objects,
            ghosts=moved_objects(before, scene),
            camera=camera,
            table_height=table_height,
        )
        for scene in answers
    ]
    return contact_sheet(pictures, captions)


def moved_objects(before: Scene, after: Scene) -> tuple[SceneObject, ...]:
    """The objects of ``before`` that stand elsewhere in ``after``."""
    return tuple(
        old
        for old, new in zip(before.objects, after.objects, strict=True)
        if not old.world_from_object.is_close(
            new.world_from_object, metres=MOVED_METRES, angle_rad=MOVED_RAD
        )
    )


def _legend(legend: Image, column: int, scene: Scene) -> None:
    """Which colour is which object."""
    middle = LEGEND_ROWS // 2
    for role, item, colour in zip(
        ('base', 'relative'), scene.objects, (BASE_COLOUR, RELATIVE_COLOUR), strict=True
    ):
        legend[middle - 6 : middle + 6, column + 2 : column + 14] = as_bytes(colour)
        letter(
            legend,
            shortened(f'{role}: {item.object_id}', 240, size=14),
            (column + 21, middle),
            size=14,
            colour=FADED_INK,
        )
        column += 270
