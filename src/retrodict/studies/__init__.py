"""How far to trust a reconstruction: studies that run it more than once."""
