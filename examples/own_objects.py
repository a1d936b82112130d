"""Your own objects: make two meshes fit for use, and let them imitate a demonstration."""

# %% Where things are; two meshes stand in for yours.
import json
import runpy
import sys
from pathlib import Path

from spatial_relations_ros.cli.pose_files import read_pose_file
from spatial_relations_ros.core import ObjectSizeError, Pose, Scene, SceneObject
from spatial_relations_ros.datasets.object_files import load_object_model
from spatial_relations_ros.datasets.own_objects import OwnObjects, prepare_object
from spatial_relations_ros.imitation import ImitationOptions, imitate
from spatial_relations_ros.learning import load_metric
from spatial_relations_ros.visualization import write_imitation_pictures

OUT = Path('out/examples/own_objects')
MESHES = OUT / 'meshes'
sys.argv = ['make_meshes.py', str(MESHES)]
runpy.run_path('examples/make_meshes.py')

# %% Units are questioned before anything is stored: this mesh is in millimetres.
try:
    prepare_object(MESHES / 'my_mug.obj')
except ObjectSizeError as error:
    print(error)

# %% With the scale, and with the axis that points up, both become watertight meshes in metres.
library = OwnObjects(OUT / 'objects')
for name in ('my_tray', 'my_mug'):
    prepared = prepare_object(MESHES / f'{name}.obj', scale=0.001, up='y')
    library.add(prepared, replace=True)
    print(f'{name}: {prepared.card.made_from}, {prepared.card.size} m')


# %% The demonstration: a cup on a plate, as tracked. The test objects: yours, beside each other.
def scene_object(object_id: str, path: Path, world_from_object: Pose) -> SceneObject:
    """An object of a model file, at a pose."""
    mesh, points = load_object_model(path)
    return SceneObject(object_id, points, world_from_object, mesh=mesh)


plate_pose, cup_pose = read_pose_file(Path('examples/cup_on_plate.json'))
reference = Scene(
    scene_object('plate', Path('bags/objects/plate.ply'), plate_pose),
    scene_object('cup', Path('bags/objects/cup.ply'), cup_pose),
)
tray = scene_object('my_tray', library.mesh_path('my_tray'), Pose())
mug = scene_object('my_mug', library.mesh_path('my_mug'), Pose())
test = Scene(
    tray.moved_to(Pose((0.0, 0.0, -float(tray.points[:, 2].min())))),
    mug.moved_to(Pose((0.3, 0.0, -float(mug.points[:, 2].min())))),
)

# %% The imitation, and what there is to see of it.
metric = load_metric()
result = imitate(metric, reference, test, ImitationOptions(seed=0))
best = result.answers[0]
print(result.message)
for placement in best.placements:
    print(placement.object_id, placement.target.translation, placement.target.quat_wxyz)
write_imitation_pictures(
    OUT,
    reference=reference,
    before=test,
    after=best.scene(test),
    projections=metric.projections,
    distance_history=result.distance_history,
)
(OUT / 'result.json').write_text(
    json.dumps(
        {
            'success': result.success,
            'distance': best.distance,
            'target': best.placements[1].target.translation.tolist(),
            'q_wxyz': best.placements[1].target.quat_wxyz.tolist(),
        },
        indent=2,
    )
)
