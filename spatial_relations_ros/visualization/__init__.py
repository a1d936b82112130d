"""Pictures of scenes, projections and curves; no ROS."""
