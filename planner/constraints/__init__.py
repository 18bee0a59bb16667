"""Constraint procedures (paper, section 5): programs that map the domains of their scope to subsets of them."""
