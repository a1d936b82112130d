"""The ``relations`` command; no ROS.

``main`` lists the commands; the module of a command is imported when that command is asked for. It
holds the options, and imports heavy libraries within the functions that compute, so that the help
and the completion of a command answer at once too.
"""
