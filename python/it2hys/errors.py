"""The one exception that stands for bad input."""


class InputError(Exception):
    """Bad input; the message names the culprit and the mend.

    The command line prints the message and exits with code 2.
    """
