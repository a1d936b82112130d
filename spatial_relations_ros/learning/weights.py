"""Reading and writing weights: safetensors with a card, checked by hash, never pickle."""

from __future__ import annotations

import dataclasses
import hashlib
from pathlib import Path

import safetensors.torch
from safetensors import SafetensorError

from spatial_relations_ros.core import ConfigError, WeightsError, atomic_write, share_path
from spatial_relations_ros.learning.calibration import PREFIX, Calibration
from spatial_relations_ros.learning.card import ModelCard
from spatial_relations_ros.learning.encoders import Encoder, make_encoder
from spatial_relations_ros.learning.metric import RelationMetric

DEFAULT_WEIGHTS = 'default.safetensors'


def card_path(weights: Path) -> Path:
    """The card beside a weights file."""
    return weights.with_suffix('.json')


def file_sha256(path: Path) -> str:
    """SHA-256 of a file, hexadecimal."""
    with open(path, 'rb') as file:
        return hashlib.file_digest(file, 'sha256').hexdigest()


def save_metric(
    encoder: Encoder, card: ModelCard, path: Path, *, calibration: Calibration | None = None
) -> ModelCard:
    """Writes weights, with their calibration, and card; returns the card with the file's hash."""
    tensors = {name: tensor.contiguous() for name, tensor in encoder.state_dict().items()}
    if calibration is not None:
        tensors |= calibration.tensors()
    with atomic_write(path) as temporary:
        safetensors.torch.save_file(tensors, temporary)
    card = dataclasses.replace(card, sha256=file_sha256(path))
    card.write(card_path(path))
    return card


def load_metric(path: Path | str | None = None, *, gradient: str | None = None) -> RelationMetric:
    """Loads a metric.

    Args:
        path: a safetensors file with its card (same name, ``.json``) beside it; None takes the
            weights that ship with the package.
        gradient: of the projection, by name, instead of the network's own; see
            :class:`~spatial_relations_ros.projection.ProjectionConfig`.

    Raises:
        WeightsError: when a file is missing, damaged, or does not fit its network.
        ConfigError: for an unknown gradient.
    """
    path = _shipped_weights() if path is None or not str(path) else Path(path).expanduser()
    if not path.is_file():
        raise WeightsError(f'weights file {path} does not exist')
    card = ModelCard.read(card_path(path))
    try:
        digest = file_sha256(path)
    except OSError as error:
        raise WeightsError(f'{path} cannot be read: {error.strerror or error}') from error
    if digest != card.sha256:
        raise WeightsError(
            f'{path} is damaged or is not what its card describes: '
            f'its SHA-256 is {digest[:12]}..., the card says {card.sha256[:12] or "nothing"}...'
        )
    try:
        encoder = make_encoder(card.encoder)
        tensors = safetensors.torch.load_file(path)
        calibration = Calibration.of_tensors(tensors)
        encoder.load_state_dict(
            {name: tensor for name, tensor in tensors.items() if not name.startswith(PREFIX)}
        )
    except (SafetensorError, RuntimeError, OSError, ConfigError) as error:
        raise WeightsError(f'{path} does not fit encoder {card.encoder!r}: {error}') from error
    if gradient is not None:
        encoder.projection = dataclasses.replace(encoder.projection, gradient=gradient)
    return RelationMetric(encoder, card, calibration)


def _shipped_weights() -> Path:
    try:
        return share_path('models', DEFAULT_WEIGHTS)
    except ConfigError as error:
        raise WeightsError(
            f'the weights that ship with the package are missing: {error}'
        ) from error
