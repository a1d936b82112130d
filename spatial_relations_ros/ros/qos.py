"""Quality of service of the topics, each for its reason."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy


def _keep_last(
    depth: int,
    *,
    reliability: ReliabilityPolicy = ReliabilityPolicy.RELIABLE,
    durability: DurabilityPolicy = DurabilityPolicy.VOLATILE,
) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=reliability,
        durability=durability,
    )


def latest_cloud(*, is_reliable: bool) -> QoSProfile:
    """Only the newest cloud: a deeper queue adds age behind a slow step, not information.

    Best effort matches every publisher. Reliable is for those that publish reliably and must not
    lose a cloud, a replayed bag for example.
    """
    policy = ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT
    return _keep_last(1, reliability=policy)


# Best effort subscriptions match every publisher; poses are small and come often.
TRACKED_POSES = _keep_last(50, reliability=ReliabilityPolicy.BEST_EFFORT)
TRANSFORMS = _keep_last(100)
STATIC_TRANSFORMS = _keep_last(100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# One cloud makes a scene of each ordered pair: 90 of ten objects.
SCENES = _keep_last(100)
# Answers stay for whoever comes late, RViz or a planner.
ANSWERS = _keep_last(1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
DIAGNOSTICS = _keep_last(10)
# Best effort, as nodes with use_sim_time subscribe.
CLOCK = _keep_last(1, reliability=ReliabilityPolicy.BEST_EFFORT)
# A burst longer than the queue would lose requests or answers: their clients would wait for ever.
REQUESTS = _keep_last(100)
