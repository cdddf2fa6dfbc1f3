from . import added  # noqa: F401  rows of the table of features
