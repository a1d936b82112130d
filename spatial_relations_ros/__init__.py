"""Live imitation of spatial relations between objects, for ROS 2."""

__version__ = '0.1.0'

__all__ = ['__version__']
