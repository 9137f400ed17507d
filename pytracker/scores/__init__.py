"""A track beside the truth: errors and how often the bands held, and intervals of figures over runs."""

from __future__ import annotations

from pytracker.scores.evaluate import JointScores, Scores, evaluate
from pytracker.scores.intervals import Interval, mean_interval, paired_difference, paired_ratio

__all__ = ["Interval", "JointScores", "Scores", "evaluate", "mean_interval", "paired_difference", "paired_ratio"]
