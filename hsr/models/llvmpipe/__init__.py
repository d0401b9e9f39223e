"""Mesa's llvmpipe, modelled stage by stage, down to the last bit."""
