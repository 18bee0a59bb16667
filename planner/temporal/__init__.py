"""Time: timepoints, the compiled kernel and its manager; networks with uncertainty, their controllability and dispatch."""
