"""What is made for one scene before it is sampled: regressions, mode, whitening."""
