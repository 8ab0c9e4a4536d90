"""Filters from the literature that are robust to gross errors and still follow a step: the rivals of `systems.monitoring`.

Each takes a `gnss.series.Series` and returns a `Followed`: a level and where a step was found, from the epochs up to each one.
"""

from gnsslab.systems.step_followers.adaptive import adaptive_follower
from gnsslab.systems.step_followers.change_point import change_point_follower
from gnsslab.systems.step_followers.cusum import cusum_follower
from gnsslab.systems.step_followers.followed import Followed
from gnsslab.systems.step_followers.multi_process import multi_process_follower

__all__ = ["Followed", "adaptive_follower", "change_point_follower", "cusum_follower", "multi_process_follower"]
