"""Parameters: declared with description and range, checked whenever they are set."""

from __future__ import annotations

import array
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter

from spatial_relations_ros.core import ConfigError

_KINDS = {bool: 'true or false', int: 'an integer', float: 'a number', str: 'a text'}

ParameterValue = bool | int | float | str | list[str] | list[float]


@dataclass(frozen=True)
class ParameterSpec:
    """One parameter.

    Attributes:
        name: lower case, the name in YAML files.
        default: its type is the parameter's type; float parameters take integers too.
        description: what it does, with its unit.
        minimum: lowest number that is accepted.
        maximum: highest number that is accepted.
        choices: the only strings that are accepted, when not empty.
        is_fixed: can be set at start only.
        may_be_nan: whether NaN is accepted, as "not known".
        is_numbers: whether a list is one of finite numbers rather than of strings.
        check: called with a value of the right type; raises a named error when it cannot be used.
    """

    name: str
    default: ParameterValue
    description: str
    minimum: float | None = None
    maximum: float | None = None
    choices: tuple[str, ...] = ()
    is_fixed: bool = False
    may_be_nan: bool = False
    is_numbers: bool = False
    check: Callable[[Any], object] | None = None

    def checked(self, value: Any) -> ParameterValue:
        """The value in the parameter's type.

        Raises:
            ConfigError: for a wrong type, a number out of range, an unknown choice, or what the
                parameter's own check refuses.
        """
        typed = self._typed(value)
        if self.check is not None:
            self.check(typed)
        return typed

    def _typed(self, value: Any) -> ParameterValue:
        if isinstance(self.default, list):
            return (
                self._checked_numbers(value) if self.is_numbers else self._checked_strings(value)
            )
        if isinstance(self.default, float) and type(value) is int:
            value = float(value)
        if 'true' in self.choices and isinstance(value, bool):
            value = str(value).lower()
        if type(value) is not type(self.default):
            raise ConfigError(f'{self.name} is {value!r}, expected {_KINDS[type(self.default)]}')
        if isinstance(value, float) and not math.isfinite(value):
            if math.isnan(value) and self.may_be_nan:
                return value
            raise ConfigError(f'{self.name} is {value}, expected a finite number')
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            self._check_range(value)
        if self.choices and value not in self.choices:
            raise ConfigError(
                f'{self.name} is {value!r}, expected one of {", ".join(self.choices)}'
            )
        return value

    def _checked_strings(self, value: Any) -> list[str]:
        values = list(value) if isinstance(value, (list, tuple)) else None
        if values is None or not all(isinstance(item, str) for item in values):
            raise ConfigError(f'{self.name} is {value!r}, expected a list of strings')
        return [item for item in values if item]

    def _checked_numbers(self, value: Any) -> list[float]:
        is_list = isinstance(value, (list, tuple, array.array))
        values: list[Any] = list(value) if is_list else []
        are_numbers = all(type(item) in (int, float) and math.isfinite(item) for item in values)
        if not (is_list and are_numbers):
            raise ConfigError(f'{self.name} is {value!r}, expected a list of finite numbers')
        return [float(item) for item in values]

    def _check_range(self, value: float) -> None:
        low = -math.inf if self.minimum is None else self.minimum
        high = math.inf if self.maximum is None else self.maximum
        if not low <= value <= high:
            raise ConfigError(f'{self.name} is {value}, expected {low} to {high}')

    def _constraints(self) -> Iterable[str]:
        if self.choices:
            yield f'one of {", ".join(self.choices)}'
        if self.is_fixed:
            yield 'read-only: set at start'

    def descriptor(self) -> ParameterDescriptor:
        """The descriptor that ``ros2 param describe`` shows."""
        descriptor = ParameterDescriptor(
            name=self.name,
            description=self.description,
            read_only=self.is_fixed,
            # Typed by ``checked``: it takes 5 for 5.0 and says clearly what is wrong.
            dynamic_typing=True,
            additional_constraints='; '.join(self._constraints()),
        )
        is_number = isinstance(self.default, (int, float)) and not isinstance(self.default, bool)
        # A range of the descriptor would refuse NaN.
        has_range = self.minimum is not None or self.maximum is not None
        if is_number and has_range and not self.may_be_nan:
            low, high = self.minimum, self.maximum
            if isinstance(self.default, int):
                descriptor.integer_range = [
                    IntegerRange(
                        from_value=-(2**31) if low is None else int(low),
                        to_value=2**31 if high is None else int(high),
                    )
                ]
            else:
                descriptor.floating_point_range = [
                    FloatingPointRange(
                        from_value=-1e308 if low is None else float(low),
                        to_value=1e308 if high is None else float(high),
                    )
                ]
        return descriptor


class Parameters:
    """The declared parameters of a node; reading gives the value that is set now."""

    def __init__(self, node: Node, specs: Sequence[ParameterSpec]) -> None:
        """Declares ``specs`` on ``node``; overrides from files and the command line apply.

        Raises:
            ConfigError: when an override cannot be used.
        """
        self._specs = {spec.name: spec for spec in specs}
        self._node = node
        # First the check, then the declarations: it sees the overrides as well.
        node.add_on_set_parameters_callback(self._on_set)
        for spec in specs:
            try:
                node.declare_parameter(spec.name, spec.default, spec.descriptor())
            except ParameterException as error:
                raise ConfigError(str(error)) from error

    def on_change(self, names: Iterable[str], callback: Callable[[], None]) -> None:
        """Has ``callback`` called after any of some parameters was set to a value that is good."""
        watched = frozenset(names)

        def changed(parameters: Sequence[Parameter]) -> None:
            if watched & {parameter.name for parameter in parameters}:
                callback()

        self._node.add_post_set_parameters_callback(changed)

    def _on_set(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            spec = self._specs.get(parameter.name)
            if spec is None:
                continue
            try:
                spec.checked(parameter.value)
            except ConfigError as error:
                return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _value(self, name: str) -> ParameterValue:
        return self._specs[name].checked(self._node.get_parameter(name).value)

    def text(self, name: str) -> str:
        """A string parameter."""
        return str(self._value(name))

    def texts(self, name: str) -> list[str]:
        """A list of strings, without empty ones."""
        value = self._value(name)
        assert isinstance(value, list)
        return [str(item) for item in value]

    def numbers(self, name: str) -> list[float]:
        """A list of numbers."""
        value = self._value(name)
        assert isinstance(value, list)
        return [float(item) for item in value]

    def number(self, name: str) -> float:
        """A float parameter."""
        value = self._value(name)
        assert isinstance(value, (int, float))
        return float(value)

    def integer(self, name: str) -> int:
        """An integer parameter."""
        return int(self.number(name))

    def flag(self, name: str) -> bool:
        """A boolean parameter."""
        return bool(self._value(name))
