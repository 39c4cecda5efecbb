"""A local page on which a scene is changed with sliders and its answer follows; computes nothing."""
