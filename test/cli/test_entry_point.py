"""The command as a process of its own."""

import json
import subprocess
import sys

COMMAND = [sys.executable, '-m', 'spatial_relations_ros.cli.main']
HEAVY = (
    'numpy', 'torch', 'open3d', 'matplotlib', 'cv2', 'rosbags', 'rclpy', 'scipy', 'sklearn',
    'metric_learn',
)  # fmt: skip


def test_loading_the_command_loads_nothing_heavy():
    code = (
        'import sys, spatial_relations_ros.cli.main; '
        f'print([name for name in {HEAVY} if name in sys.modules])'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == '[]'


def test_help_names_every_command():
    done = subprocess.run([*COMMAND, '--help'], capture_output=True, text=True, check=True)
    for name in (
        'generate', 'train', 'retrieve', 'imitate', 'embed', 'distance', 'generalize', 'replay',
        'bench', 'remember', 'nearest', 'list', 'forget', 'version', 'objects',
    ):  # fmt: skip
        assert f' {name} ' in done.stdout


def test_help_shows_the_pose_format_whole():
    done = subprocess.run(
        [*COMMAND, 'imitate', '--help'], capture_output=True, text=True, check=True
    )
    words = ' '.join(done.stdout.split())
    assert '"base": {"t": [x,y,z], "q_wxyz": [w,x,y,z]}' in words


def test_a_real_run(data, weights):
    done = subprocess.run(
        [
            *COMMAND, 'distance', '--data', data, '--reference', 'tray_cup_0',
            '--test', 'tray_cup_0', '--weights', weights, '--json', '-',
        ],
        capture_output=True,
        text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)['distance'] < 1e-3


def test_errors_reach_the_shell(tmp_path):
    notes = tmp_path / 'notes.txt'
    notes.write_text('not a database, but long enough to look at ' * 10)
    done = subprocess.run(
        [*COMMAND, 'list', '--memory', str(notes)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert done.stdout == ''
    assert done.stderr.startswith('error: ')
    assert 'Traceback' not in done.stderr
