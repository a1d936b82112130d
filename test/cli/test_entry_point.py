"""The command as a process of its own."""

import json
import os
import re
import subprocess
import sys

COMMAND = [sys.executable, '-m', 'spatial_relations_ros.cli.main']
HEAVY = (
    'numpy', 'torch', 'open3d', 'matplotlib', 'cv2', 'rosbags', 'rclpy', 'scipy', 'sklearn',
    'metric_learn',
)  # fmt: skip


def modules_loaded_by(*arguments):
    """The modules that one run of the command imports."""
    code = (
        'import sys\n'
        'from spatial_relations_ros.cli.main import app\n'
        f'app({list(arguments)!r}, standalone_mode=False)\n'
        'print(*sys.modules, sep="\\n", file=sys.stderr)'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert 'Usage: ' in done.stdout
    return set(done.stderr.split())


def test_help_loads_no_command_and_nothing_heavy():
    loaded = modules_loaded_by('--help')
    assert not loaded & set(HEAVY)
    assert not {name for name in loaded if re.search(r'cli\.\w+_commands?$', name)}


def test_help_of_a_command_loads_that_command_alone():
    loaded = modules_loaded_by('imitate', '--help')
    assert not loaded & set(HEAVY)
    commands = {name for name in loaded if re.search(r'cli\.\w+_commands?$', name)}
    assert commands == {'spatial_relations_ros.cli.imitate_command'}


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


def completions(words):
    """What the shell is told at the end of ``words``."""
    environment = {
        **os.environ, '_RELATIONS_COMPLETE': 'complete_bash', 'COMP_WORDS': words,
        'COMP_CWORD': str(len(words.split(' ')) - 1),
    }  # fmt: skip
    done = subprocess.run(
        [sys.executable, '-c', 'from spatial_relations_ros.cli.main import main; main()'],
        capture_output=True,
        text=True,
        check=False,
        env=environment,
    )
    return done.stdout.split()


def test_the_shell_completes_commands_options_and_choices():
    assert completions('relations re') == ['replay', 'remember', 'retrieve']
    assert completions('relations objects s') == ['show']
    assert '--reference-poses' in completions('relations imitate --ref')
    assert completions('relations imitate --movable b') == ['base', 'both']
