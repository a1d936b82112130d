"""The fenced commands of the documentation's pages."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Beginnings of the reasons for which commands are not run.
REASONS = (
    'needs sudo', 'needs a ROS 2 host', 'needs two processes', 'needs bags of yours',
    'takes minutes', 'takes hours', 'is run in docs/tutorials/train.md',
)  # fmt: skip
# Pages of measurements: their commands are checked, not run.
MEASUREMENTS = {
    'docs/results.md': 'takes hours', 'docs/perception.md': 'takes hours',
    'docs/imitation.md': 'takes hours', 'docs/manipulator.md': 'takes hours',
    'docs/generated-data.md': 'takes hours', 'models/README.md': 'takes hours',
}  # fmt: skip
PROGRAMS = ('relations', 'make', 'python', 'ros2', 'colcon', 'pip', 'torchrun')

FENCE = re.compile(
    r'(?:^<!-- (?P<mark>[^\n]+) -->\n)?^```(?P<language>\w*)\n(?P<body>.*?)^```',
    flags=re.MULTILINE | re.DOTALL,
)


@dataclass(frozen=True)
class Block:
    """A fenced block.

    Attributes:
        page: path below the repository.
        language: of the fence.
        body: its lines.
        mark: the comment right before it, empty without one.
    """

    page: str
    language: str
    body: str
    mark: str

    @property
    def reason(self) -> str:
        """Why it is not run; empty when it is."""
        if self.page in MEASUREMENTS:
            return MEASUREMENTS[self.page]
        return self.mark.removeprefix('not run: ') if self.mark.startswith('not run: ') else ''

    @property
    def exit_codes(self) -> tuple[int, ...]:
        """Those that are right."""
        return tuple(int(code) for code in re.findall(r'\d', self.mark)) if (
            self.mark.startswith('exit code')
        ) else (0,)  # fmt: skip

    @property
    def commands(self) -> list[list[str]]:
        """The words of each command, without comments; a backslash at the end goes on."""
        lines = self.body.replace('\\\n', ' ').splitlines()
        return [words for line in lines if (words := shlex.split(line, comments=True))]

    @property
    def holds_commands(self) -> bool:
        """Whether it is for a shell, by its language or by its looks."""
        if self.language:
            return self.language in ('sh', 'bash', 'console', 'shell')
        return any(line.strip().startswith(PROGRAMS) for line in self.body.splitlines())


def pages() -> list[str]:
    """All pages in Markdown, below the repository."""
    found = [
        *ROOT.glob('*.md'), *(ROOT / 'docs').rglob('*.md'), *(ROOT / 'examples').glob('*.md'),
        *(ROOT / 'models').glob('*.md'),
    ]  # fmt: skip
    names = sorted(str(path.relative_to(ROOT)) for path in found)
    return [name for name in names if not name.startswith('docs/reference/')]


def blocks(page: str) -> list[Block]:
    """The fenced blocks of a page."""
    text = (ROOT / page).read_text(encoding='utf-8')
    return [
        Block(page, match['language'], match['body'], match['mark'] or '')
        for match in FENCE.finditer(text)
    ]
