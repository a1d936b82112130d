"""What a motion planner needs of an imitation: order, ways in, gripper poses. No robot here."""

# %% A demonstration, two objects to place, something in the way.
import json
from pathlib import Path

import numpy as np

from spatial_relations_ros.cli.pose_files import read_pose_file
from spatial_relations_ros.core import Pose, Scene, SceneObject
from spatial_relations_ros.datasets.object_files import load_object_model
from spatial_relations_ros.imitation import ArmReach, ImitationOptions, Obstacle, imitate
from spatial_relations_ros.learning import load_metric
from spatial_relations_ros.visualization import render_scene, write_image

OUT = Path('out/examples/moves')
MODELS = Path('bags/objects')


def scene_object(object_id: str, world_from_object: Pose) -> SceneObject:
    """An object of the recorded demonstration, at a pose."""
    mesh, points = load_object_model(MODELS / f'{object_id}.ply')
    return SceneObject(object_id, points, world_from_object, mesh=mesh)


def standing(object_id: str, x: float, y: float) -> SceneObject:
    """The same, upright on a table at z = 0."""
    item = scene_object(object_id, Pose())
    return item.moved_to(Pose((x, y, -float(item.mesh.vertices[:, 2].min()))))


plate_pose, cup_pose = read_pose_file(Path('examples/cup_on_plate.json'))
reference = Scene(scene_object('plate', plate_pose), scene_object('cup', cup_pose))
test = Scene(standing('tray', 0.0, 0.0), standing('mug', 0.3, 0.1))
basket = standing('basket', -0.3, 0.0)

# %% The arm's shoulder, and where the gripper holds the mug: from above, 10 cm over its origin.
object_from_gripper = Pose((0.0, 0.0, 0.1), (0.0, 1.0, 0.0, 0.0))
options = ImitationOptions(
    num_answers=3,
    obstacles=(Obstacle.of_object(basket),),
    arm=ArmReach(np.array([[-0.2, -0.5, 0.3]])),
    grasps={'mug': object_from_gripper},
    approach_height=0.12,
    seed=0,
)
result = imitate(load_metric(), reference, test, options)
print(result.message)


# %% For each move: go to gripper_approach, straight on to gripper_target, open.
def entry(pose: Pose | None) -> dict[str, list[float]] | None:
    """A pose as JSON."""
    if pose is None:
        return None
    return {'t': pose.translation.tolist(), 'q_wxyz': pose.quat_wxyz.tolist()}


best = result.answers[0]
placement_of = {placement.object_id: placement for placement in best.placements}
moves = [
    {
        'object': move.object_id,
        'to_target': move.to_target,
        'reachable': placement_of[move.object_id].reachable,
        'way_is_clear': placement_of[move.object_id].approach_clear,
        'gripper_approach': entry(placement_of[move.object_id].gripper_approach),
        'gripper_target': entry(placement_of[move.object_id].gripper_target),
    }
    for move in best.order
]
OUT.mkdir(parents=True, exist_ok=True)
content = {'feasible': best.feasible, 'violations': best.violations, 'moves': moves}
(OUT / 'moves.json').write_text(json.dumps(content, indent=2))
after = best.scene(test)
write_image(
    OUT / 'moves.png',
    render_scene([*after.objects, basket], ghosts=[test.relative], table_height=0.0),
)
