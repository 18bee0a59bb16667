"""A survey rover whose model has a constraint procedure of its own."""
