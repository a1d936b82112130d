"""Remembered relations; no ROS."""
