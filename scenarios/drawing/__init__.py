"""A flexible plan as a picture: timelines, bounds, and the temporal constraints between them (paper, Figure 1)."""
