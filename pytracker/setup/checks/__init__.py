"""The parts of a check: of an `arm` by its `camera`, its `imu`, which way is `down` and how it is `worn`; of a `body`.

Each gives `findings`, a line each.
"""
