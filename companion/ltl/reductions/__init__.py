"""Reductions: smaller automata for the same language, a module for each technique.

trimming              states that accept nothing, marks that say nothing
bisimulation          states that do the same in all steps
simulation            states that do all that another one does
quotient              one state for those, and no edge that a better one covers
sharpening            disjoint cubes
weak_determinisation  the smallest weak deterministic automaton of an obligation
degeneralisation      one acceptance set, and it a set of states
strategy              their order
"""
