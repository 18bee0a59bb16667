"""Deep Space 1: the planner's domain model and how its tokens become commands and telemetry."""
