"""The page: its template, style and script with the data set in."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Sequence
from importlib import resources
from pathlib import Path

from spatial_relations_ros.core import ConfigError, atomic_write
from spatial_relations_ros.visualization.report.content import report_content
from spatial_relations_ros.visualization.report.sections import ReportSection, sections_html
from spatial_relations_ros.visualization.shown_imitation import ShownImitation

MAX_BYTES = 5_000_000

# The part of the template that shows imitations, with its script.
_IMITATIONS = re.compile('<!-- imitations -->.*?<!-- /imitations -->', flags=re.DOTALL)
_SCRIPTS = ('matrices.js', 'viewer.js', 'curve.js', 'report.js')


def write_report(
    path: Path | str,
    imitations: Sequence[ShownImitation],
    *,
    title: str = 'Imitation',
    sections: Sequence[ReportSection] = (),
) -> Path:
    """Writes a report page; a crash never leaves half of one.

    Args:
        path: where to, ``.html``.
        imitations: at least one, or none with ``sections``; several can be chosen from on the
            page.
        title: of the page.
        sections: facts and pictures above them.

    Returns:
        The path written.

    Raises:
        ConfigError: for another suffix, or nothing to show.
    """
    path = Path(path)
    if path.suffix.lower() not in ('.html', '.htm'):
        raise ConfigError(f'a report is written as .html, got {path.name!r}')
    text = report_html(imitations, title=title, sections=sections)
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding='utf-8')
    return path


def report_html(
    imitations: Sequence[ShownImitation],
    *,
    title: str = 'Imitation',
    sections: Sequence[ReportSection] = (),
) -> str:
    """The page's text, the same for the same content.

    Models are simplified further until the page is below 5 MB.

    Raises:
        ConfigError: without anything to show, or with so much that it cannot be made small.
    """
    if not (imitations or sections) or not all(shown.answers for shown in imitations):
        raise ConfigError('a report needs at least one imitation with an answer')
    template = page_part('template.html').replace('@SECTIONS@', sections_html(sections))
    if not imitations:
        template = _IMITATIONS.sub('', template)
    style = page_part('report.css')
    script = '\n'.join(page_part(name) for name in _SCRIPTS)
    for num_triangles in (8000, 4000, 2000, 1000, 500):
        content = report_content(imitations, title=title, num_triangles=num_triangles)
        # "</script>" within a string would end the element.
        data = json.dumps(content, separators=(',', ':'), allow_nan=False).replace('<', '\\u003c')
        page = (
            template.replace('@TITLE@', html.escape(title))
            .replace('@STYLE@', style)
            .replace('@SCRIPT@', script)
            .replace('@DATA@', data)
        )
        if len(page.encode()) < MAX_BYTES:
            return page
    raise ConfigError(
        f'{len(imitations)} imitations do not fit into a page of {MAX_BYTES // 1_000_000} MB; '
        'report fewer'
    )


def page_part(name: str) -> str:
    """The text of a part of the page, ``viewer.js`` for instance, for other pages to use."""
    return resources.files(__package__).joinpath(name).read_text(encoding='utf-8')
