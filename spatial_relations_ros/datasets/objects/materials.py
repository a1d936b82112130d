"""Densities of what objects are made of or filled with, kg / m^3."""

FILLED, PAPER, CARDBOARD = 700.0, 800.0, 400.0
WOOD, PLASTIC, RUBBER = 650.0, 950.0, 600.0
CERAMIC, METAL, GLASS = 2200.0, 4000.0, 2400.0
