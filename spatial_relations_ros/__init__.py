"""Live imitation of spatial relations between objects, for ROS 2."""

import os

# Read by OpenMP when PyTorch is first imported. Threads that wait by spinning, its default, fight
# for the cores with whatever else runs: on two busy cores an imitation took 45 s instead of 5 s.
os.environ.setdefault('OMP_WAIT_POLICY', 'PASSIVE')

__version__ = '0.1.0'

__all__ = ['__version__']
