"""Example problems in NDDL, each saying at its top what it shows."""
