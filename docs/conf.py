"""How Sphinx builds these pages: ``make docs``."""

import re
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from reference_pages import write_reference  # noqa: E402

from spatial_relations_ros import __version__  # noqa: E402

project = 'spatial_relations_ros'
version = release = __version__
author = 'spatial_relations_ros maintainers'
project_copyright = 'spatial_relations_ros maintainers, Apache-2.0'

extensions = ['myst_parser']
exclude_patterns = ['*.py']
myst_enable_extensions = ['colon_fence']
# Links such as cli.md#objects: the anchors that GitHub gives to headings.
myst_heading_anchors = 4
smartquotes = False
nitpicky = True

html_theme = 'furo'
html_title = f'Spatial relations {__version__}'
html_show_sphinx = False
html_copy_source = False

# Pages made from the code lie beside the others while they are built; git ignores them.
write_reference(HERE / 'reference')


def name_files_outside(app: Any, docname: str, source: list[str]) -> None:
    """Links to files of the repository that are no pages lead nowhere here: tells their path."""
    folder = Path(app.env.doc2path(docname)).parent

    def shown(link: re.Match[str]) -> str:
        path = (folder / link[2]).resolve()
        if path.is_relative_to(HERE) or not path.exists():
            return link[0]
        name = str(path.relative_to(HERE.parent))
        return f'`{name}`' if name in link[1] else f'{link[1]} (`{name}`)'

    source[0] = re.sub(r'(?<!!)\[([^\]]+)\]\((\.\.[^)#\s]*)\)', shown, source[0])


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect('source-read', name_files_outside)
