"""What the command's exit status says."""

DONE, FELL_SHORT, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
