"""The ``relations`` command; no ROS."""
