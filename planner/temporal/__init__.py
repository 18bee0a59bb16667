"""Time: timepoints, the compiled kernel and its manager; networks with uncertainty and their controllability."""
