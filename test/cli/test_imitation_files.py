"""What ``relations imitate`` writes for people to look at."""

import json
import re
from pathlib import Path

import pytest


def imitate(relations, scene_files, weights, *options):
    return relations(
        'imitate', *scene_files['reference'].options('reference'),
        *scene_files['test'].options('test'), '--weights', weights, '--steps', 2,
        '--answers', 2, *options,
    )  # fmt: skip


def test_the_report_tells_what_the_json_tells(relations, scene_files, weights, tmp_path):
    page, results, way = (tmp_path / name for name in ('out.html', 'out.json', 'out.webp'))
    result = imitate(
        relations, scene_files, weights, '--report', page, '--json', results, '--animation', way
    )
    assert isinstance(result.exception, SystemExit | None), repr(result.exception)
    assert way.stat().st_size > 5000
    found = re.search(r'type="application/json">(.*?)</script>', page.read_text(), re.S)
    assert found is not None
    (case,) = json.loads(found[1])['cases']
    answers = json.loads(results.read_text())['answers']
    assert len(case['answers']) == len(answers)
    for shown, answer in zip(case['answers'], answers, strict=True):
        assert shown['distance'] == pytest.approx(answer['distance'], abs=1e-5)
        assert shown['feasible'] == answer['feasible']
        ends = shown['way'][-1]['poses']
        for pose, role in zip(ends, ('base', 'relative'), strict=True):
            told = answer['poses'][role]
            assert pose == pytest.approx([*told['t'], *told['q_wxyz']], abs=1e-5)
        named = [value for name, value, _ in shown['checks'] if name == 'violated']
        assert named == answer['violations']
    assert [item['id'] for item in case['reference']['objects']] == ['tray', 'cup']


@pytest.mark.parametrize(
    ('option', 'name', 'complaint'),
    [
        ('--report', 'out.pdf', 'ends with .html or .htm'),
        ('--animation', 'out.avi', 'ends with .gif or .webp or .mp4'),
    ],
)
def test_a_wrong_file_is_refused_before_the_work(
    relations, scene_files, weights, tmp_path, option, name, complaint
):
    result = imitate(relations, scene_files, weights, option, tmp_path / name)
    assert result.exit_code == 2
    assert complaint in ' '.join(result.stderr.split())


def test_a_replay_is_reported_frame_by_frame(relations, weights, tmp_path):
    bag = Path(__file__).resolve().parents[2] / 'bags'
    page = tmp_path / 'replay.html'
    result = relations(
        'replay', bag / 'demo', '--models', bag / 'objects', '--reference', 'plate', 'cup',
        '--test', 'tray', 'mug', '--frame', 5, '--weights', weights, '--report', page,
    )  # fmt: skip
    assert isinstance(result.exception, SystemExit | None), repr(result.exception)
    found = re.search(r'type="application/json">(.*?)</script>', page.read_text(), re.S)
    assert found is not None
    (case,) = json.loads(found[1])['cases']
    assert case['title'] == 'frame 5'
    assert [item['id'] for item in case['test']['objects']] == ['tray', 'mug']


def test_all_pictures_lie_in_the_folder_and_the_overview_is_shown(
    relations, scene_files, weights, tmp_path, monkeypatch
):
    monkeypatch.delenv('DISPLAY', raising=False)
    monkeypatch.delenv('WAYLAND_DISPLAY', raising=False)
    monkeypatch.setenv('TMPDIR', str(tmp_path))
    monkeypatch.setattr('tempfile.tempdir', None)
    result = imitate(relations, scene_files, weights, '--out', tmp_path / 'out', '--show')
    names = {path.name for path in (tmp_path / 'out').iterdir()}
    assert {'overview.png', 'answers.png', 'test_before_gradients.png', 'result.json'} <= names
    shown = re.search(r'picture:\s+(\S+overview\.png)', result.output.replace('\n', ''))
    assert shown is not None, result.output
    assert list(tmp_path.glob('relations-*/overview.png'))


def test_a_recording_holds_the_imitation(relations, scene_files, weights, tmp_path):
    rerun = pytest.importorskip('rerun', reason='needs rerun-sdk (extra viz)')
    path = tmp_path / 'out.rrd'
    imitate(relations, scene_files, weights, '--rerun', path)
    chunks = rerun.chunk.RrdReader(str(path)).stream().to_chunks()
    entities = {chunk.entity_path for chunk in chunks}
    assert {'/test/can', '/reference/cup', '/distance', '/projections/test'} <= entities


def test_a_recording_that_cannot_be_written_is_refused_before_the_work(
    relations, scene_files, weights, tmp_path
):
    result = imitate(relations, scene_files, weights, '--rerun', tmp_path / 'out.mp4')
    assert result.exit_code == 2
