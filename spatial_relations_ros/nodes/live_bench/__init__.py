"""The live benchmark: a publisher, the real perception node, and a subscriber that measures."""
