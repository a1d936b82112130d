"""An imitation as a moving picture: the objects on their way, the distance curve beside."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
from PIL import Image as PillowImage

from spatial_relations_ros.core import ConfigError, atomic_write
from spatial_relations_ros.visualization.camera import frame_objects
from spatial_relations_ros.visualization.curves import NEAREST_WHILE_SEARCHING, draw_distance_curve
from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.palette import PAPER, as_bytes
from spatial_relations_ros.visualization.rendering import render_scene
from spatial_relations_ros.visualization.sheets import moved_objects
from spatial_relations_ros.visualization.shown_imitation import (
    Poses,
    ShownImitation,
    ShownStep,
    pose_between,
    way_to,
)

ANIMATION_SUFFIXES = ('.gif', '.webp', '.mp4')
NUM_FRAMES = 32
FRAMES_PER_SEC = 12.0
HOLD_SEC = 1.5


def animate_imitation(
    shown: ShownImitation,
    *,
    num_frames: int = NUM_FRAMES,
    width: int = 480,
    height: int = 360,
    on_frame: Callable[[int], None] | None = None,
) -> list[Image]:
    """Pictures of the test objects from where they stood to the best answer.

    Between two moments poses move along a straight line, whatever lies between; what has moved
    is left behind as a ghost. The curve is that of the way which is shown, or without its
    distances that of the search.

    Args:
        shown: the imitation.
        num_frames: how many pictures, at least two.
        width: of the scene, pixels; the curve beside it is as wide.
        height: pixels.
        on_frame: told how many pictures are done.

    Returns:
        (height, 2 * width, 3) uint8 RGB each.

    Raises:
        ConfigError: for fewer than two pictures or an imitation without an answer.
    """
    if num_frames < 2:
        raise ConfigError(f'an animation needs at least two pictures, got {num_frames}')
    if not shown.answers:
        raise ConfigError('there is no answer to animate')
    way = way_to(shown)
    scenes = [shown.before.with_poses(*step.poses) for step in way]
    camera = frame_objects([scene.objects for scene in scenes], width=width, height=height)
    measured = [step.distance for step in way if step.distance is not None]
    follows = 2 < len(measured) == len(way)
    distances = measured if follows else shown.history
    frames = []
    for idx, at in enumerate(np.linspace(0.0, len(way) - 1.0, num_frames)):
        now = shown.before.with_poses(*_poses_at(way, float(at)))
        picture = render_scene(
            now.objects,
            ghosts=moved_objects(shown.before, now),
            camera=camera,
            table_height=shown.table,
        )
        curve = draw_distance_curve(
            distances,
            title='Distance to the demonstration' if follows else NEAREST_WHILE_SEARCHING,
            width=width,
            height=height,
            cursor=float(at) if follows else None,
            steps='moment of the way shown' if follows else 'step of the search',
        )
        frames.append(np.concatenate([picture, curve], axis=1))
        if on_frame is not None:
            on_frame(idx + 1)
    return frames


def write_animation(
    path: Path | str,
    frames: Sequence[Image],
    *,
    frames_per_sec: float = FRAMES_PER_SEC,
    hold_sec: float = HOLD_SEC,
) -> Path:
    """Writes pictures as GIF, WebP or MP4; a crash never leaves half of one.

    Args:
        path: where to; the suffix chooses the format. GIF and WebP repeat for ever.
        frames: (H, W, 3) uint8 RGB each, all of one size, at least one.
        frames_per_sec: how fast.
        hold_sec: how long the last picture stays.

    Returns:
        The path written.

    Raises:
        ConfigError: for another suffix, without pictures, or where video cannot be encoded.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in ANIMATION_SUFFIXES:
        raise ConfigError(
            f'animations are written as {", ".join(ANIMATION_SUFFIXES)}, got {path.name!r}'
        )
    if not frames or len({frame.shape for frame in frames}) != 1:
        raise ConfigError('an animation needs pictures of one size')
    with atomic_write(path) as temporary:
        if suffix == '.mp4':
            held = [frames[-1]] * round(hold_sec * frames_per_sec)
            _write_video(temporary, [*frames, *held], frames_per_sec)
        else:
            _write_pillow(temporary, suffix, frames, frames_per_sec, hold_sec)
    return path


def _write_pillow(
    path: Path, suffix: str, frames: Sequence[Image], frames_per_sec: float, hold_sec: float
) -> None:
    pictures = [PillowImage.fromarray(frame) for frame in frames]
    milliseconds = [round(1000.0 / frames_per_sec)] * len(pictures)
    milliseconds[-1] += round(1000.0 * hold_sec)
    if suffix == '.gif':
        # One palette for all, so that still parts do not flicker.
        stripe = PillowImage.fromarray(np.concatenate(frames[:: max(1, len(frames) // 6)]))
        palette = stripe.quantize(255)
        pictures = [
            picture.quantize(palette=palette, dither=PillowImage.Dither.NONE)
            for picture in pictures
        ]
    pictures[0].save(
        path,
        format=suffix[1:].upper(),
        save_all=True,
        append_images=pictures[1:],
        duration=milliseconds,
        loop=0,
        **({'quality': 85} if suffix == '.webp' else {}),
    )


def _write_video(path: Path, frames: Sequence[Image], frames_per_sec: float) -> None:
    # The codec takes even sizes only.
    height, width = (side + side % 2 for side in frames[0].shape[:2])
    codec = cv2.VideoWriter.fourcc(*'mp4v')
    writer = cv2.VideoWriter(str(path), codec, frames_per_sec, (width, height))
    if not writer.isOpened():
        raise ConfigError('OpenCV cannot encode mp4 here; .gif and .webp work everywhere')
    try:
        for frame in frames:
            padded = np.empty((height, width, 3), dtype=np.uint8)
            padded[:] = as_bytes(PAPER)
            padded[: frame.shape[0], : frame.shape[1]] = frame
            writer.write(np.ascontiguousarray(padded[..., ::-1]))
    finally:
        writer.release()


def _poses_at(way: Sequence[ShownStep], at: float) -> Poses:
    """Poses at a place between two moments of the way."""
    idx = max(0, min(int(at), len(way) - 2))
    start, end = way[idx].poses, way[min(idx + 1, len(way) - 1)].poses
    share = at - idx
    return pose_between(start[0], end[0], share), pose_between(start[1], end[1], share)
