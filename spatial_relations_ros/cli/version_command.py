"""``relations version``."""

from __future__ import annotations

from spatial_relations_ros import __version__
from spatial_relations_ros.cli.output import JsonOption, Output
from spatial_relations_ros.cli.provenance import git_revision, library_versions


def version(json_path: JsonOption = None) -> None:
    """Show the version of the package and of what it computes with."""
    output = Output(json_path)
    libraries = library_versions()
    output.say(f'spatial_relations_ros {__version__}')
    output.table(('library', 'version'), list(libraries.items()))
    output.write_json(
        {'version': __version__, 'git_revision': git_revision(), 'libraries': libraries}
    )
