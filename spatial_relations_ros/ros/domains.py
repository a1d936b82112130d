"""Choosing a ROS_DOMAIN_ID that nobody on this machine uses."""

from __future__ import annotations

import os
from pathlib import Path

# Up to 101 all ports lie below Linux's ephemeral ones.
HIGHEST_DOMAIN_ID = 101
PORT_BASE, PORTS_PER_DOMAIN = 7400, 250


def used_udp_ports() -> frozenset[int]:
    """Local UDP ports that are bound on this machine."""
    ports = set()
    for table in (Path('/proc/net/udp'), Path('/proc/net/udp6')):
        if table.exists():
            for line in table.read_text(encoding='ascii').splitlines()[1:]:
                ports.add(int(line.split()[1].rpartition(':')[2], 16))
    return frozenset(ports)


def free_domain_id() -> int:
    """A domain without participants on this machine; callers at the same time get others.

    DDS binds a port of a known number for each domain; the search starts at one given by the
    process id.
    """
    ports = used_udp_ports()
    for offset in range(HIGHEST_DOMAIN_ID):
        domain_id = 1 + (os.getpid() + offset) % HIGHEST_DOMAIN_ID
        first = PORT_BASE + PORTS_PER_DOMAIN * domain_id
        if not any(first <= port < first + PORTS_PER_DOMAIN for port in ports):
            return domain_id
    return 1 + os.getpid() % HIGHEST_DOMAIN_ID
