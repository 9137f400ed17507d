"""Skeletons: bones, channels, limits and outer shape; the average one of a given height."""

from __future__ import annotations

from pytracker._core import KEY_JOINTS
from pytracker.skeleton.average import average_skeleton
from pytracker.skeleton.skeleton import UPPER_BODY, Bone, Part, Skeleton

__all__ = ["KEY_JOINTS", "UPPER_BODY", "Bone", "Part", "Skeleton", "average_skeleton"]
