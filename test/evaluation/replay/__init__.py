"""Replays of a small simulated bag: a package, so that its files share how it is made."""
