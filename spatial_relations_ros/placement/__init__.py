"""Solid objects at rest: contacts, balance, and ways to place one around another; no ROS.

``model`` is an object with its mass, its opening and the ways in which it rests; ``body`` the same
prepared for contact queries and at a pose; ``contact`` and ``stability`` say where two touch and
whether they stay; ``on``, ``inside`` and ``leaning_on`` place one around another.
"""
