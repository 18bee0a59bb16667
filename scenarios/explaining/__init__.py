"""Why: why each token of a plan is there, and which statements of a problem leave no plan."""
