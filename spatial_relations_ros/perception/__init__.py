"""Clouds, tracks and frames into scenes; no ROS."""
