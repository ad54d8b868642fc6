"""Translates a formula, and draws its Büchi automaton to automaton.png.

G(found -> F reported) & G(reported -> X at(Home))
3 states, 3 propositions, 1 set of accepting transitions
"""

from companion import parse_formula, translate

formula = parse_formula("G (found -> F reported) & G (reported -> X at(Home))")
automaton = translate(formula)

print(formula)
print(
    f"{automaton.states} states, {len(automaton.propositions)} propositions, "
    f"{automaton.marks} set of accepting transitions"
)
