"""Pictures of scenes, projections and curves; no ROS, no display, no GPU.

- Scenes: ``render_scene``, ``before_after``, ``answer_sheet``, ``contact_sheet``; ``Camera`` and
  ``frame_objects`` say from where, ``write_image`` and ``terminal_picture`` where to.
- What the network sees: ``draw_projections``, ``draw_projection_gradients``.
- An imitation (``ShownImitation``): ``write_imitation_pictures``, ``animate_imitation`` with
  ``write_animation``, ``write_report``; with Rerun ``recordings`` and ``recorded_imitation``.
- Measurements: ``draw_distance_curve``, ``draw_embedding_map``, ``draw_confusion``,
  ``draw_neighbour_sheet``.

All pictures are (H, W, 3) uint8 RGB arrays; lengths are metres, base is blue, relative is orange.
"""

from spatial_relations_ros.visualization.animations import animate_imitation, write_animation
from spatial_relations_ros.visualization.camera import Camera, frame_objects, frame_points
from spatial_relations_ros.visualization.confusions import draw_confusion
from spatial_relations_ros.visualization.curves import draw_distance_curve
from spatial_relations_ros.visualization.embedding_maps import draw_embedding_map
from spatial_relations_ros.visualization.images import Image, read_image, write_image
from spatial_relations_ros.visualization.imitation_pictures import write_imitation_pictures
from spatial_relations_ros.visualization.neighbour_sheets import (
    ShownScene,
    draw_neighbour_sheet,
)
from spatial_relations_ros.visualization.palette import (
    BASE_COLOUR,
    OBJECT_COLOURS,
    RELATIVE_COLOUR,
)
from spatial_relations_ros.visualization.projection_gradients import draw_projection_gradients
from spatial_relations_ros.visualization.projections import draw_projections
from spatial_relations_ros.visualization.rendering import render_scene
from spatial_relations_ros.visualization.report import (
    ReportSection,
    report_html,
    write_report,
)
from spatial_relations_ros.visualization.sheets import answer_sheet, before_after, contact_sheet
from spatial_relations_ros.visualization.shown_imitation import (
    ShownAnswer,
    ShownCheck,
    ShownImitation,
    ShownStep,
    pose_between,
    straight_way,
    way_to,
)
from spatial_relations_ros.visualization.terminal import terminal_picture
from spatial_relations_ros.visualization.timelines import Curve, Timeline, draw_timelines

__all__ = [
    'BASE_COLOUR',
    'Camera',
    'Curve',
    'Image',
    'OBJECT_COLOURS',
    'RELATIVE_COLOUR',
    'ReportSection',
    'ShownAnswer',
    'ShownCheck',
    'ShownImitation',
    'ShownScene',
    'ShownStep',
    'Timeline',
    'animate_imitation',
    'answer_sheet',
    'before_after',
    'contact_sheet',
    'draw_confusion',
    'draw_distance_curve',
    'draw_embedding_map',
    'draw_neighbour_sheet',
    'draw_projection_gradients',
    'draw_projections',
    'draw_timelines',
    'frame_objects',
    'frame_points',
    'pose_between',
    'read_image',
    'render_scene',
    'report_html',
    'straight_way',
    'terminal_picture',
    'way_to',
    'write_animation',
    'write_image',
    'write_imitation_pictures',
    'write_report',
]
