"""NDDL: the text language of timeline models, as its last interpreter reads it, and what this project adds to it.

    model, program, report = load(Path("rover.nddl"), STANDARD)     # NddlError says all that is wrong with the file
    database = PlanDatabase(model, program.horizon)
    program.carry_out(database, report)          # Inconsistency: the statements contradict each other

Reading order:

    errors.py                    diagnostics with file, line, column and a caret
    lexer.py reader.py           text to tokens; a cursor over them
    syntax.py                    the frozen tree
    expressions.py definitions.py parser.py printer.py      tokens to tree and back
    loader.py library.py         includes; the headers that are built in
    symbols.py scope.py values.py    what names mean
    operators.py kinds.py comparisons.py relations.py states.py translator.py   statements to those of rules
    causality.py model_builder.py objects.py limits.py  tree to model
    methods.py program.py        the problem, carried out on a plan database
    builder.py                   the whole way

The parser is written by hand on one regular expression, not generated from a grammar. Both were tried: in one run over
the same scheduling problem of 119 kB, lark 1.3 (LALR, contextual lexer) took 3.5 ms a kilobyte to an untyped tree,
this parser 0.85 ms to the typed one (processor time, best of five). NDDL tells statements apart by what follows a
name, reserves words only where they mean something, and `[1 -5]` holds two numbers where `1 -5` is a difference:
tricks in a grammar, a line each by hand. And an error can say what a modeller would want to know, and reading goes on
after it.

Extensions of the language, beside the paper's relations and their bounds (`before[10 20](camera.ready r);`):

- `contingent duration = [5 9];` in a predicate: nature decides the duration within these bounds. A plan never chooses
  or shortens it, and is good only if it can be kept whatever nature chooses.
- `exogenous predicate p {...}`: no plan brings it about; it is where the problem's facts say, and nowhere else.
- `attribute mode { predicate p {...} ... }` in a class: a timeline `object.mode` for these predicates, so that one
  object may have several. Rules name the predicates as ever: `Camera::off`, `meets(camera.off o)`.
- `either {...} or {...}` in a rule or a problem: at least one of the branches holds; the search tries the first one
  first. The idiom with a `bool` and two guards says the same, with a variable that is decided like any other.
- `only equals {lamp.dark, lamp.dim(level == [0 2])};` in a rule: a constraint token. Over an interval in that relation
  to the rule's token (any of the relations, with bounds) an attribute has only these values, and may change among
  them; a parameter may equal a variable or be one of a set.
- A global variable that is declared with a number (`int WARM_UP = 300;`) may be a bound: `contingent duration =
  [WARM_UP WARM_UP_MAX];`, `before[0 WARM_UP](...)`. A rule sees the number, not a variable.
- A model's own constraint procedures: Python callables (planner/constraints/user.py), by `--procedures FILE.py` or in
  the registry that `load` takes. `headers` are texts for files that a model includes: how a program hands it numbers.

    model, _, _ = load_text(text, STANDARD.with_procedures(turn_duration), headers={"capability.nddl": "int N = 3;"})

scenarios/ds1/domain.nddl uses all of them.
"""
