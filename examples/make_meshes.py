"""Two meshes as they come from elsewhere: millimetres, y up, one with a hole."""

import sys
from pathlib import Path

import numpy as np

from spatial_relations_ros.datasets.objects import sample_object

folder = Path(sys.argv[1] if len(sys.argv) > 1 else 'my_meshes')
folder.mkdir(parents=True, exist_ok=True)
rng = np.random.default_rng(4)
for family, holes in (('tray', 0), ('mug', 2)):
    mesh = sample_object(family, rng).mesh
    x, y, z = (1000.0 * mesh.vertices).T
    lines = [f'v {a:.3f} {b:.3f} {c:.3f}' for a, b, c in zip(x, z, -y, strict=True)]
    triangles = mesh.triangles[: len(mesh.triangles) - holes] + 1
    lines += ['f ' + ' '.join(map(str, triangle)) for triangle in triangles.tolist()]
    path = folder / f'my_{family}.obj'
    path.write_text('\n'.join(lines) + '\n', encoding='utf-8')
    print(path)
