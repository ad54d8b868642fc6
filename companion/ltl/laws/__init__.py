"""Laws of linear temporal logic that make formulas simpler.

sides        U with |, R with &: each law is written once
fixpoints    laws of U and R
chains       laws of | and &
implication  which formulas imply which
facts        what holds at all positions
"""
