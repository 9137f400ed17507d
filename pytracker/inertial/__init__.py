"""What every IMU log must pass, whatever file it came from, and what it tells of itself.

Numbers, times and units, gravity, turns, gaps, outliers, bias, and an orientation where it has none.
"""
