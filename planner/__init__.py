"""The plan database and its search: attributes, tokens, timelines, configuration constraints, flexible plans.

Reading order: `model`, `language`, `domains`, `constraints`, `temporal`, `tokens`, `database`, `search`, `planning`.
Imports neither `executive` nor `sim`.
"""
