"""Scenarios: the only package that brings planner, executive and spacecraft together."""
