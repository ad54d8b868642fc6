"""Translates a formula, and draws its Büchi automaton to automaton.png.

G(found -> F reported) & G(reported -> X at(Home))
3 states, 8 transitions, 1 acceptance mark
"""

import networkx as nx
from matplotlib.figure import Figure

from companion import parse_formula, translate

formula = parse_formula("G (found -> F reported) & G (reported -> X at(Home))")
automaton = translate(formula)
graph = automaton.to_networkx()

print(formula)
print(
    f"{len(graph)} states, {graph.number_of_edges()} transitions, {automaton.marks} acceptance mark"
)

labels = {
    (source, target, key): edge["label"] + (" *" if edge["marks"] else "")  # * for ever again
    for source, target, key, edge in graph.edges(keys=True, data=True)
}
axes = Figure(figsize=(9, 9)).subplots()
axes.margins(0.2)
places, curved = nx.circular_layout(graph), "arc3,rad=0.2"
nx.draw_networkx(graph, places, ax=axes, connectionstyle=curved, node_color="lightgrey")
nx.draw_networkx_edge_labels(graph, places, labels, ax=axes, connectionstyle=curved)
axes.figure.savefig("automaton.png")
