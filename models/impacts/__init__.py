"""Impact models: momentum alone, and the planar impact of SAE 770014 in four variants."""
