"""The token network manager (paper, sections 3 and 4): tokens, timelines with slots, resources, rule instances."""
