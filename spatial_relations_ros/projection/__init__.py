"""Depth images of scenes and their gradients; no ROS."""
