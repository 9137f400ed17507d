"""The parts of a check: of a `camera`, an `imu`, which way is `down`, how it is `worn`, a `body`.

Each gives `findings`, a line each.
"""
