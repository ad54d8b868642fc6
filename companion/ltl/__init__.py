"""Linear temporal logic: formulas, their meaning, and Büchi automata that accept their words.

    text -> parser (patterns) -> formula -> translate -> automaton -> hoa, dot, networkx
    translate: simplify -> tableau -> reductions -> automaton (-> state based)

`semantics` decides whether a lasso word satisfies a formula. `monitor` decides what a finite word
already tells about a formula. `restriction` reduces an automaton for propositions that keep their
value. `budget` limits the cost of a translation. The package imports `errors`, and no other module
of the companion.

>>> from companion.ltl.parser import parse
>>> from companion.ltl.translate import translate
>>> [str(t.label) for t in translate(parse("G (a -> X b)")).transitions]
['!a', 'a', '!a & b', 'a & b']
"""
