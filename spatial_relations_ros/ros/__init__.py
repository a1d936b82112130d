"""Conversions between messages and the core, parameters, QoS."""
