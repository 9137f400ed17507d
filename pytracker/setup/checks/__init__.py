"""The parts of a check: of a `camera`, an `imu`, how it is `worn`, a `body`; each gives `findings`, a line each."""
