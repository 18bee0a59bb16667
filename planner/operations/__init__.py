"""The three operations of the paper (sections 3 and 4), in any order, any of them undone at any time.

- Insert a token on a timeline: into a slot of its own, or by codesignation with a token that has one. A constraint
  token lies over the slots of its timeline and takes none.
- Remove it from there: undo its insertion.
- Modify the domain of a variable: restrict it, and undo the restriction.

The semantics, to which everything here keeps:

1. *The partial plan is a function of the operations in force*, taken in the order in which they were issued: the least
   fixpoint of their constraints, of the rules of the tokens that they make active, and of the guards that they decide,
   together with the order of the tokens on their timelines. Undoing an operation gives exactly the plan of those that
   are left, whatever happened in between.
2. *Operations name tokens and variables by path*, never by number or identity: a token that goes and comes back is the
   same token to them.
3. *An operation whose token is gone, or whose host is not active, is dormant*. It is tried again, in order of issue,
   after every change until nothing changes, and comes back when its token does. One that would then be inconsistent
   with what is in force stays dormant, with the reason, and is tried again in the same way.
4. *The order of two tokens of a timeline is fixed when the later of them is inserted*, and never changes as long as
   neither insertion is undone: a token comes after the nearest predecessor it had then that is there now, dormant ones
   counted as predecessors. The precedences between neighbours follow from that order. On which side of a constraint
   token a value token is, inserting leaves open: that is the domain of a variable.
5. *A guard whose test is no longer decided withdraws what it made*: its tokens go, and the operations on them become
   dormant.
6. *A new operation that is inconsistent is refused*: it leaves no trace, and the refusal names the operations, rules
   and given facts that together make it impossible.
"""

from planner.operations.operations import Operations, Refusal
from planner.operations.statements import Codesignation, Insertion, Operation, Restriction

__all__ = ["Codesignation", "Insertion", "Operation", "Operations", "Refusal", "Restriction"]
