"""The one place where float64 is switched on, for mechanics and inference alike."""

import jax

jax.config.update("jax_enable_x64", True)
