"""Search engines: each sees flaws, decisions and undo, never the model (paper, section 4)."""
