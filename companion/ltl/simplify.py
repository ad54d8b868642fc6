from companion.ltl.formula import *


def simplified(f):
    return f
