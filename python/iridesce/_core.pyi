"""Types of the compiled core. Private: the public modules check and document, then call these."""

__version__: str
