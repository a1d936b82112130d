"""Relations remembered under names, and the most alike among them; no ROS."""

from spatial_relations_ros.memory.neighbours import Neighbour
from spatial_relations_ros.memory.relation_memory import Embed, RelationMemory
from spatial_relations_ros.memory.relation_rows import RememberedRelation
from spatial_relations_ros.memory.schema import default_memory_path

__all__ = [
    'Embed',
    'Neighbour',
    'RelationMemory',
    'RememberedRelation',
    'default_memory_path',
]
