"""Encoders, the metric and its training; no ROS."""
