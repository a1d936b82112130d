"""Retrieval, replay and reports; no ROS."""
