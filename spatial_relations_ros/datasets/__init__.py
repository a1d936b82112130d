"""The paper's folder format, object models and generated scenes; no ROS."""
