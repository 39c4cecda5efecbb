"""Physical constants that several layers use."""

GRAVITY = 9.80665  # m/s², standard
