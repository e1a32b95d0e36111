"""The next experiment: a voltage to play that decides what records so far could not.

`limits` says what a rig can play, `families` what may be played within them, `hypotheses` between what
is to be decided, `promise` what a record would decide, `designing` finds the best one.
"""
