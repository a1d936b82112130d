"""The live panel: a web page about what perception sees, and for imitations.

``server``, ``hub``, ``commands`` and ``origins`` know nothing of ROS; ``imitations`` and
``relations`` ask the other nodes.
"""
