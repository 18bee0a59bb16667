"""The model manager (paper, section 4): classes, attributes, predicates, relations, configuration constraints."""
