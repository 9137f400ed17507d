"""Synthetic recordings with truth: for the demo, for tests and benches, and for trying a set-up before filming."""

from __future__ import annotations

from pytracker.simulate.arm import ArmSimulation
from pytracker.simulate.arm_scene import ArmScene
from pytracker.simulate.body import BodyScene, simulate_body
from pytracker.simulate.write import simulate_arm

__all__ = ["ArmScene", "ArmSimulation", "BodyScene", "simulate_arm", "simulate_body"]
