"""How far answers of an imitation can be believed, which were chosen for their distance."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from spatial_relations_ros.core import WeightsError

# Nothing is more certain: a calibration holds for what it was measured on.
_CERTAINTY = 1e-3
# An arrangement that is off by as much is another way to show the relation; more says no more.
MOST_DIFFERENCE = 0.5


@dataclass(frozen=True)
class AnswerCalibration:
    """From a metric's probability of the same relation to that of a right imitation.

    The probabilities of :class:`Calibration` are those of any two scenes. An answer is the nearest
    of many placements, so it is right less often than a scene that lies as near by chance. Their
    log odds are scaled and shifted (Platt 1999), as a judge who knows geometry alone said of
    answers; it is stored in the card of the weights. So is what it counts against an answer that
    its arrangement is another one, which the metric tells apart least.

    Attributes:
        slope: of the log odds; above 0.
        offset: added to them.
        doubt: taken from them for each unit of an arrangement's difference, of which no more than
            a half counts; 0 or more.
        typical: difference of answers whose arrangement is not known; 0 or more.

    Raises:
        WeightsError: for values that are no calibration.
    """

    slope: float
    offset: float
    doubt: float = 0.0
    typical: float = 0.0

    def __post_init__(self) -> None:
        values = (self.slope, self.offset, self.doubt, self.typical)
        least = min(self.doubt, self.typical)
        if not (all(map(math.isfinite, values)) and self.slope > 0.0 and least >= 0.0):
            raise WeightsError(
                f'a calibration of answers of slope {self.slope}, offset {self.offset}, doubt '
                f'{self.doubt}, typical difference {self.typical} cannot be used; the slope must '
                'be above 0, doubt and difference not below, all finite'
            )

    def probability(self, same_relation: float, difference: float | None = None) -> float:
        """That an answer imitates the demonstration, 0 to 1.

        Args:
            same_relation: the metric's probability of that.
            difference: of its arrangement from the demonstration's, as answers have it; None
                where that is not known.
        """
        log_odds = self.slope * log_odds_of(same_relation) + self.offset
        difference = self.typical if difference is None else difference
        log_odds -= self.doubt * min(difference, MOST_DIFFERENCE)
        return 1.0 / (1.0 + math.exp(-log_odds))

    @staticmethod
    def of_card(entry: Mapping[str, Any]) -> AnswerCalibration | None:
        """Out of a card's entry; None where it is empty.

        Raises:
            WeightsError: when it makes no sense.
        """
        if not entry:
            return None
        try:
            return AnswerCalibration(
                float(entry['slope']),
                float(entry['offset']),
                float(entry.get('doubt', 0.0)),
                float(entry.get('typical', 0.0)),
            )
        except (KeyError, TypeError, ValueError) as error:
            raise WeightsError(
                f'the calibration of answers in the card is not usable: {error!r}; expected '
                'numbers for slope and offset'
            ) from error


def log_odds_of(probability: float) -> float:
    """Of a probability, which is taken to be no nearer to 0 and 1 than 0.001."""
    kept = min(max(probability, _CERTAINTY), 1.0 - _CERTAINTY)
    return math.log(kept / (1.0 - kept))
