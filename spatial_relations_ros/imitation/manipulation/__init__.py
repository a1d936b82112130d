"""What a manipulator needs of an answer: room beside obstacles, reach, ways in, order."""

from spatial_relations_ros.imitation.manipulation.moves import Move
from spatial_relations_ros.imitation.manipulation.obstacle_check import check_obstacles
from spatial_relations_ros.imitation.manipulation.obstacles import (
    Obstacle,
    obstacle_depths,
    without_strays,
)
from spatial_relations_ros.imitation.manipulation.reach import ArmReach

__all__ = ['ArmReach', 'Move', 'Obstacle', 'check_obstacles', 'obstacle_depths', 'without_strays']
