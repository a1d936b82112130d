"""Who may talk to the panel: pages that came from it, under a name that is its own.

A page of another site can open a WebSocket to any address, and can make its own name lead to this
machine (DNS rebinding). The first is seen by its Origin, the second by its Host.
"""

from __future__ import annotations

import ipaddress
from collections.abc import Collection
from urllib.parse import urlsplit


def host_name(host: str) -> str | None:
    """The name or address in a Host header, without the port; None for what is none."""
    try:
        name = urlsplit(f'//{host}').hostname
    except ValueError:
        return None
    return name.rstrip('.') if name else None


def is_own_host(host: str, own_names: Collection[str]) -> bool:
    """Whether a Host header names this panel.

    Addresses are taken: the name of another site cannot be one, so none was rebound. Names must
    be ``localhost`` or among ``own_names`` (lower case).
    """
    name = host_name(host)
    if name is None:
        return False
    if name == 'localhost' or name in own_names:
        return True
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def is_same_origin(origin: str | None, host: str) -> bool:
    """Whether an Origin header is that of a page which this host served."""
    if not origin:
        return False
    try:
        parts = urlsplit(origin)
    except ValueError:
        return False
    return parts.scheme in ('http', 'https') and parts.netloc.lower() == host.lower()
