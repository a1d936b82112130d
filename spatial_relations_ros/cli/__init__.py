"""The ``relations`` command; no ROS.

Nothing here imports a heavy library when it is loaded: commands import what they need, so that
``relations --help`` answers at once.
"""
