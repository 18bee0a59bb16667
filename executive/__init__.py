"""The executive: carries out flexible plans on a plant, keeps a journal, and asks for a new plan when one breaks.

Knows the port, the plan and `planner.planning`; never the simulator.
"""
