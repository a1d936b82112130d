"""Tests on one graph of the three nodes: a package, so that all its files share the graph."""
