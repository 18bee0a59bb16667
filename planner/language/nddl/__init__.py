"""NDDL."""
