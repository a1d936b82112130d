"""Parts of a page that need no script: facts and pictures."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from dataclasses import dataclass

from spatial_relations_ros.visualization.images import Image, png_bytes


@dataclass(frozen=True, eq=False)
class ReportSection:
    """What is told above the imitations.

    Attributes:
        title: of the section.
        facts: name and value of each row of its table.
        pictures: caption and (H, W, 3) uint8 RGB of each.
    """

    title: str
    facts: tuple[tuple[str, str], ...] = ()
    pictures: tuple[tuple[str, Image], ...] = ()


def sections_html(sections: Sequence[ReportSection]) -> str:
    """The elements of the sections; pictures lie within."""
    return '\n'.join(_section_html(section) for section in sections)


def _section_html(section: ReportSection) -> str:
    rows = ''.join(
        f'<tr><td>{html.escape(name)}</td><td>{html.escape(value)}</td></tr>'
        for name, value in section.facts
    )
    pictures = ''.join(
        f'<figure><figcaption>{html.escape(caption)}</figcaption>'
        f'<img alt="{html.escape(caption)}" src="data:image/png;base64,'
        f'{base64.b64encode(png_bytes(image)).decode()}"></figure>'
        for caption, image in section.pictures
    )
    return (
        f'<section class="section"><h2>{html.escape(section.title)}</h2>'
        f'<table>{rows}</table>{pictures}</section>'
    )
