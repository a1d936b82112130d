"""The report page: what it holds."""

from __future__ import annotations

import base64
import dataclasses
import json
import re

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, Pose, TriangleMesh
from spatial_relations_ros.visualization import (
    ShownAnswer,
    pose_between,
    report_html,
    way_to,
    write_report,
)

QUARTER_TURN = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])


def data_of(page: str) -> dict:
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', page, re.S)
    assert found is not None
    return json.loads(found[1])


def test_the_way_to_an_answer_holds_what_changed(shown):
    way = way_to(shown)
    assert [step.distance for step in way] == [2.0, 1.0, 0.25]
    assert way[0].poses == shown.start
    assert way[-1].poses == shown.answers[0].poses
    assert [step.poses for step in way_to(shown, 1)] == [shown.start, shown.answers[1].poses]
    stays = dataclasses.replace(shown, steps=(), answers=(ShownAnswer(shown.start, 2.0, True),))
    assert len(way_to(stays)) == 1


def test_between_two_poses_lies_half_of_the_turn():
    middle = pose_between(Pose(np.zeros(3)), Pose(np.array([0.2, 0.0, 0.0]), -QUARTER_TURN), 0.5)
    np.testing.assert_allclose(middle.translation, [0.1, 0.0, 0.0])
    np.testing.assert_allclose(
        np.abs(middle.quat_wxyz), [np.cos(np.pi / 8), 0, 0, np.sin(np.pi / 8)]
    )


def test_the_page_holds_scenes_steps_and_checks(shown):
    data = data_of(report_html([shown, shown], title='two'))
    assert len(data['cases']) == 2
    assert len(data['models']) == 2, 'the same box and the same cloud are stored once'
    case = data['cases'][0]
    assert [item['id'] for item in case['test']['objects']] == ['tray', 'cup']
    assert case['test']['table'] == pytest.approx(0.0, abs=1e-3)
    assert [step['step'] for step in case['answers'][0]['way']] == [0, 3, 3]
    assert case['answers'][0]['checks'] == [['distance', '0.25', True]]
    assert case['answers'][1]['distance'] is None
    assert case['history'] == [2.0, 1.0, None, 0.25]
    np.testing.assert_allclose(
        case['answers'][0]['way'][-1]['poses'][1], [0, 0, 0.1, *QUARTER_TURN], atol=1e-6
    )


def test_shapes_survive_the_packing(shown):
    data = data_of(report_html([shown]))
    base = data['cases'][0]['test']['objects'][0]
    model = data['models'][base['model']]
    levels = np.frombuffer(base64.b64decode(model['positions']), '<u2').reshape(-1, 3)
    box = shown.before.base.mesh
    np.testing.assert_allclose(model['low'] + model['step'] * levels, box.vertices, atol=1e-5)
    triangles = np.frombuffer(base64.b64decode(model['triangles']), '<u2').reshape(-1, 3)
    np.testing.assert_array_equal(triangles, box.triangles)
    cloud = data['models'][data['cases'][0]['test']['objects'][1]['model']]
    assert 'triangles' not in cloud


def test_the_page_needs_nothing_from_elsewhere(shown):
    page = report_html([shown])
    assert re.findall(r'(?:src|href)\s*=', page) == []
    without_namespace = page.replace('http://www.w3.org/2000/svg', '')
    assert 'http' not in without_namespace.replace('http-equiv', '')
    assert "default-src 'none'" in page


def test_names_cannot_break_out_of_the_page(shown):
    evil = '</script><script>alert(1)</script>'
    page = report_html([dataclasses.replace(shown, title=evil, message=evil)], title=evil)
    assert evil not in page
    assert data_of(page)['cases'][0]['title'] == evil


def test_large_meshes_are_simplified_until_the_page_is_small(shown):
    angles = np.linspace(0.0, np.pi, 400)
    rings = np.stack(np.meshgrid(angles, 2.0 * angles), axis=-1).reshape(-1, 2)
    vertices = np.stack(
        [
            np.sin(rings[:, 0]) * np.cos(rings[:, 1]),
            np.sin(rings[:, 0]) * np.sin(rings[:, 1]),
            np.cos(rings[:, 0]),
        ],
        axis=1,
    )
    index = np.arange(400 * 400).reshape(400, 400)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    quads = np.stack([a, b, c, d], axis=-1).reshape(-1, 4)
    ball = TriangleMesh(vertices / 20.0, np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]))
    large = dataclasses.replace(
        shown.before, base=dataclasses.replace(shown.before.base, mesh=ball)
    )
    page = report_html([dataclasses.replace(shown, before=large)])
    assert len(page) < 500_000


def test_what_cannot_be_written(shown, tmp_path):
    with pytest.raises(ConfigError, match=r'written as \.html'):
        write_report(tmp_path / 'report.pdf', [shown])
    with pytest.raises(ConfigError, match='at least one imitation'):
        write_report(tmp_path / 'report.html', [])
    with pytest.raises(ConfigError, match='with an answer'):
        write_report(tmp_path / 'report.html', [dataclasses.replace(shown, answers=())])
    assert list(tmp_path.iterdir()) == []
