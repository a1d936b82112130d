"""Pose optimisation through the metric, and feasibility; no ROS."""
