"""Linear temporal logic: formulas, their meaning, and Büchi automata that accept what they say.

    text -> parser (patterns) -> formula -> translate -> automaton -> hoa, dot, networkx
    translate: simplify -> tableau -> reductions -> automaton (-> state based)

`semantics` decides whether a lasso word satisfies a formula, `monitor` what a finite word says of
it; `restriction` is what is left of an automaton while some propositions keep their value; `budget`
limits the cost of a translation. Of the companion's other modules only `errors` is imported.

>>> from companion.ltl.parser import parse
>>> from companion.ltl.translate import translate
>>> [str(t.label) for t in translate(parse("G (a -> X b)")).transitions]
['!a', 'a', '!a & b', 'a & b']
"""
