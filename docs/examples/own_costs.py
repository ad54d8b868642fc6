"""Plans a round trip with costs of one's own: a table of seconds, then energy against the wind.

by table   move(Home, B), move(B, A), move(A, Home)
eastwards  move(Home, B), move(B, A), move(A, Home)
"""
