"""The messages in docs/faq.md are those of the code."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / 'docs' / 'faq.md').read_text(encoding='utf-8')
MESSAGES = re.findall(r'\*\*`([^`]+)`\*\*|^ *\| `([^`]+)` \|', PAGE, flags=re.MULTILINE)
HOLE = '\0'


def text_of(node):
    """A string as written, with a hole where something is filled in."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    if isinstance(node, ast.BinOp):
        return text_of(node.left) + text_of(node.right)
    if isinstance(node, ast.JoinedStr):
        return ''.join(
            part.value if isinstance(part, ast.Constant) else HOLE for part in node.values
        )
    return HOLE


@pytest.fixture(scope='module')
def texts():
    """All strings of the package, and what the scripts of CI say."""
    found = [
        text_of(node)
        for path in (ROOT / 'spatial_relations_ros').rglob('*.py')
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8')))
        if isinstance(node, (ast.Constant, ast.JoinedStr, ast.BinOp))
    ]
    return '\n'.join([*found, (ROOT / '.ci' / 'check-system').read_text(encoding='utf-8')])


def test_there_are_messages():
    assert len(MESSAGES) > 30


@pytest.mark.parametrize('message', [first or second for first, second in MESSAGES])
def test_the_message_stands_in_the_code(message, texts):
    parts = [re.escape(part) for part in message.split('…')]
    assert re.search(f'[^\n]*?{HOLE}[^\n]*?'.join(parts), texts)
