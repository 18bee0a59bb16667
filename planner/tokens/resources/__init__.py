"""Resources of a plan: transactions on reservoirs and reusable resources, and the levels that they make.

transaction.py  what a token takes and gives, as events at timepoints
steps.py        limits that change over time
closure.py      the heaviest closed set of a partial order, by maximum flow
precedence.py   which events cannot happen without which others, from the temporal network
ledger.py       the envelope of a level, its profile at earliest times, its first violation
clash.py        what overdraws a resource, and the remedies
timetable.py    pruning by what happens in every schedule
uses.py         the constraint `uses`
resource.py     all of it for one object of the model
"""

from planner.tokens.resources.clash import Clash, Precede, Remedy, Within
from planner.tokens.resources.ledger import Band
from planner.tokens.resources.resource import Pruning, Resource
from planner.tokens.resources.uses import PendingUse

__all__ = ["Band", "Clash", "PendingUse", "Precede", "Pruning", "Remedy", "Resource", "Within"]
