"""panel_node: a web page on this machine to see objects and imitate with them."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping, Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

from spatial_relations_ros.core import (
    ConfigError,
    FrameTransformError,
    SceneObject,
    SpatialRelationsError,
)
from spatial_relations_ros.nodes.panel.commands import (
    CancelCommand,
    Command,
    ForgetCommand,
    ImitateCommand,
    RememberCommand,
)
from spatial_relations_ros.nodes.panel.imitations import Imitations
from spatial_relations_ros.nodes.panel.relations import RefusedError, Relations
from spatial_relations_ros.nodes.panel.seen_objects import SeenObjects, Shapes
from spatial_relations_ros.nodes.panel_parameters import PANEL_PARAMETERS
from spatial_relations_ros.nodes.perception_parameters import model_source
from spatial_relations_ros.nodes.perception_states import read_states
from spatial_relations_ros.nodes.scene_client import SceneClient
from spatial_relations_ros.nodes.scene_requests import with_mesh
from spatial_relations_ros.nodes.transform_listener import TransformListener
from spatial_relations_ros.perception.track_state import TrackState
from spatial_relations_ros.ros.diagnostics import OK, State
from spatial_relations_ros.ros.qos import DIAGNOSTICS
from spatial_relations_ros.ros.relations_node import RelationsNode
from spatial_relations_ros.ros.running import run_node
from spatial_relations_ros.ros.timers import steady_timer

try:
    from spatial_relations_ros.nodes.panel.server import PanelServer
except ModuleNotFoundError as error:
    # aiohttp is an optional dependency of this node alone.
    if (error.name or '').partition('.')[0] != 'aiohttp':
        raise
    PanelServer = None  # type: ignore[assignment,misc]

RELATIONS_PERIOD_SEC = 2.0
STALE_SEC = 5.0


class PanelNode(RelationsNode):
    """Serves the panel and asks the other nodes what it needs."""

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__('panel_node', PANEL_PARAMETERS, **node_arguments)
        try:
            self._set_up()
        except Exception:  # half a node must not stay in the graph
            self.destroy_node()
            raise

    def _set_up(self) -> None:
        if PanelServer is None:
            raise ConfigError(
                'panel_node needs aiohttp: install it with `sudo apt install python3-aiohttp` or '
                '`pip install aiohttp`'
            )
        self._models = model_source(self.parameters.text('models_path'))
        self._shapes = Shapes()
        self._objects = SeenObjects(self._shapes)
        self._scenes = SceneClient(self)
        self._relations = Relations(self)
        self._states: Mapping[str, tuple[TrackState | None, str]] = {}
        self._states_problem = ''
        self._states_sec = -1e9
        self._camera_frame = self.parameters.text('camera_frame')
        self._transforms = TransformListener(self) if self._camera_frame else None
        self._perception = self.resolve_service_name(self.parameters.text('perception'))
        self._server = PanelServer(
            self,
            host=self.parameters.text('host'),
            port=self.parameters.integer('port'),
            own_names=self.parameters.texts('allowed_hosts'),
        )
        self._imitations = Imitations(
            self, self._scenes, self._models, self._shapes, self._server.publish
        )
        self.subscribe(DiagnosticArray, '/diagnostics', self._on_diagnostics, DIAGNOSTICS)
        address = self._server.start()
        self.diagnostics.add_state(
            'panel', lambda: State(OK, address, {'browsers': self._server.num_browsers})
        )
        for period_sec, show in (
            (1.0 / self.parameters.number('rate'), self._show_objects),
            (RELATIONS_PERIOD_SEC, self._show_relations),
        ):
            steady_timer(self, period_sec, show, group=MutuallyExclusiveCallbackGroup())
        self.get_logger().info(f'panel on {address}')

    def close(self) -> None:
        """Ends the server and what it waits for."""
        super().close()
        if hasattr(self, '_imitations'):  # not when the node could not be set up
            self._imitations.close()
        if hasattr(self, '_server'):
            self._server.close()

    def destroy_node(self) -> None:
        """Ends the server first."""
        self.close()
        if hasattr(self, '_imitations'):
            self._imitations.destroy()
        super().destroy_node()

    def obey(self, command: Command) -> str:
        """Carries out what a browser asks; on a thread of the server.

        Raises:
            SpatialRelationsError: why it cannot be carried out.
        """
        try:
            return self._obeyed(command)
        except SpatialRelationsError:
            raise
        except Exception as error:  # the browser gets the reason, the panel lives
            raise RefusedError(self.report_bad('panel', error)) from error

    def model(self, key: str) -> str | None:
        """The shape of that key; on the thread of the server."""
        return self._shapes.text(key)

    def _obeyed(self, command: Command) -> str:
        if isinstance(command, ImitateCommand):
            self._imitations.start(command)
            return 'asked'
        if isinstance(command, CancelCommand):
            return 'cancelling' if self._imitations.cancel() else 'nothing runs'
        if isinstance(command, RememberCommand):
            said = self._relations.remember(command)
        else:
            assert isinstance(command, ForgetCommand)
            said = self._relations.forget(command)
        self._show_relations()
        return said

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        wanted = f'{self._perception.lstrip("/")}: objects'
        for status in message.status:
            if status.name == wanted:
                self._states = read_states({item.key: item.value for item in status.values})
                has_states = bool(self._states)
                self._states_problem = '' if has_states else str(status.message)
                self._states_sec = time.monotonic()

    def _show_objects(self) -> None:
        if not self._server.num_browsers:
            return
        try:
            self._server.publish('objects', self._objects_content(), only_changes=True)
        except Exception as error:  # from a timer it would end the node
            self.report_bad('objects', error)

    def _objects_content(self) -> dict[str, Any]:
        seen: dict[str, SceneObject] = {}
        table_height, problem = None, self._states_problem
        tracked = sorted(key for key, (state, _) in self._states.items() if state == 'TRACKED')
        age_sec = time.monotonic() - self._states_sec
        if age_sec > STALE_SEC:
            self._states = {}
            problem = f'nothing is heard of {self._perception}; is it running?'
        elif len(tracked) > 1:
            try:
                given = self._scenes.seen(tracked[:2], with_others=True)
                objects = (*given.scene.objects, *given.others)
                seen = {item.object_id: with_mesh(item, self._models) for item in objects}
                table_height = given.table_height
            except SpatialRelationsError as error:
                problem = str(error)
        return {
            'objects': self._objects.content(self._states, seen),
            'table': table_height,
            'eye': self._eye(),
            'problem': problem,
        }

    def _eye(self) -> list[float] | None:
        """Where the camera is in the world; None while that is not known."""
        if self._transforms is None:
            return None
        try:
            world_frame = self.parameters.text('world_frame')
            pose = self._transforms.world_from(world_frame, self._camera_frame, 0)
        except FrameTransformError:
            return None
        return [round(float(value), 3) for value in pose.translation]

    def _show_relations(self) -> None:
        if not self._server.num_browsers:
            return
        content: dict[str, Any] = {'relations': [], 'problem': ''}
        try:
            if self._relations.is_ready:
                content['relations'] = self._relations.content()
            else:
                content['problem'] = 'no metric node is there: relations cannot be remembered'
        except Exception as error:  # from a timer it would end the node
            content['problem'] = self.report_bad('relations', error)
        self._server.publish('relations', content, only_changes=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the node until it is asked to stop; returns the exit code."""
    return run_node(PanelNode, arguments)


if __name__ == '__main__':
    sys.exit(main())
