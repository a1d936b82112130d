"""Evaluate a bag: perception of each cloud, an imitation, and what to look at."""

# %% The bag that ships; for yours change these, and world_frame in PerceptionConfig.
import json
from pathlib import Path

from matplotlib.figure import Figure

from spatial_relations_ros.cli.imitation_files import shown_imitation
from spatial_relations_ros.evaluation.replay import ReplayOptions, replay_bag
from spatial_relations_ros.evaluation.replay_report import summary
from spatial_relations_ros.imitation import ImitationOptions
from spatial_relations_ros.learning import load_metric
from spatial_relations_ros.pipeline import LibraryModels, PerceptionConfig, Pipeline
from spatial_relations_ros.visualization import write_report

BAG, MODELS = Path('bags/demo'), Path('bags/objects')
REFERENCE, TEST = ('plate', 'cup'), ('tray', 'mug')
OUT = Path('out/examples/bag')
OUT.mkdir(parents=True, exist_ok=True)

# %% The same steps as live; nothing depends on the clock, so the results repeat.
pipeline = Pipeline(PerceptionConfig(world_frame='world'), LibraryModels(MODELS))
metric = load_metric()
report = replay_bag(
    BAG,
    pipeline,
    metric,
    ReplayOptions(REFERENCE, TEST, frame_idxs=(10,), imitation=ImitationOptions(seed=0)),
)
print(summary(report))

# %% How much of each object the clouds confirm, over time: below 0.4 it is not believed.
start_ns = report.frames[0].stamp_ns
figure = Figure(figsize=(8, 4), layout='constrained')
axes = figure.subplots()
for object_id in sorted({name for frame in report.frames for name in frame.object_ids}):
    seen = [frame for frame in report.frames if object_id in frame.object_ids]
    axes.plot(
        [(frame.stamp_ns - start_ns) / 1e9 for frame in seen],
        [frame.states[object_id].support for frame in seen],
        label=object_id,
    )
axes.set(xlabel='s', ylabel='support', ylim=(0, 1.05), title='Confirmed share of each object')
axes.legend(ncols=4)
figure.savefig(OUT / 'support.png', dpi=100)

# %% The imitation as a page in 3-D, and the reasons for what could not be used.
for frame in report.frames:
    if frame.imitation is not None and frame.scenes is not None:
        shown = shown_imitation(
            metric,
            *frame.scenes,
            frame.imitation,
            table_height=frame.table_height,
        )
        write_report(OUT / 'report.html', [shown], title='mug to tray as cup to plate')
rejected = {f.frame_idx: dict(f.rejected) for f in report.frames if f.rejected}
(OUT / 'summary.json').write_text(json.dumps({**summary(report), 'rejected': rejected}, indent=2))
