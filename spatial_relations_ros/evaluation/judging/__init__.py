"""Judging scenes by geometry on full meshes, apart from the metric and from the generator.

``judge_scene`` says which of the seven relations a scene shows, and why; ``compare_relations``
whether a result shows that of a reference, in class and within tolerances of its continuous part.
"""

from spatial_relations_ros.evaluation.judging.agreement import (
    Agreement,
    Difference,
    Tolerances,
    compare_relations,
)
from spatial_relations_ros.evaluation.judging.judge import (
    JudgeLimits,
    Judgement,
    decide,
    judge_scene,
)
from spatial_relations_ros.evaluation.judging.measures import Measures, measure_scene

__all__ = [
    'Agreement',
    'Difference',
    'JudgeLimits',
    'Judgement',
    'Measures',
    'Tolerances',
    'compare_relations',
    'decide',
    'judge_scene',
    'measure_scene',
]
