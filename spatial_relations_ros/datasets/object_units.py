"""Which unit a model file is in, judged by how large its object would be."""

from __future__ import annotations

from spatial_relations_ros.core import ObjectSizeError

# Largest extents of things that stand on tables, metres. Within the first pair no question is
# asked; what somebody scales on purpose may reach the second.
USUAL_EXTENT = (0.01, 1.0)
LARGEST_EXTENTS = (0.004, 4.0)

# Metres in a unit, and how large objects are whose files are in it; millimetres are commonest.
_UNITS = {
    'millimetres': (0.001, 0.02, 1.0),
    'centimetres': (0.01, 0.03, 0.4),
    'inches': (0.0254, 0.06, 0.5),
}


def check_extent(name: str, extent: float, *, on_purpose: bool = False) -> None:
    """Refuses an object that is too large or small to stand on a table.

    Args:
        name: of the object, for the message.
        extent: its largest side, metres.
        on_purpose: whether somebody said how large it is, by a scale or a size.

    Raises:
        ObjectSizeError: naming the unit that the file probably has and the scale for it.
    """
    low, high = LARGEST_EXTENTS if on_purpose else USUAL_EXTENT
    if low <= extent <= high:
        return
    if on_purpose:
        raise ObjectSizeError(
            f'{name} would be {extent:.4g} m large; between {low:g} and {high:g} m is possible'
        )
    raise ObjectSizeError(f'{name} is {extent:.4g} m large: {unit_hint(extent)}')


def unit_hint(extent: float) -> str:
    """What to do about a model whose largest side would be so many metres."""
    fitting = {
        unit: scale for unit, (scale, low, high) in _UNITS.items() if low <= extent * scale <= high
    }
    by_size = '--size 0.15 makes its largest side 15 cm, and --scale 1 keeps it in metres'
    if not fitting:
        return f'in no common unit would it stand on a table; {by_size}'
    options = ' or '.join(
        f'{unit} (--scale {scale:g}: {extent * scale:.3g} m)' for unit, scale in fitting.items()
    )
    if len(fitting) == 1:
        (unit, scale), *_ = fitting.items()
        return f'probably {unit}; use --scale {scale:g}'
    return f'{options}?'
