"""The compiled half of the package."""

__version__: str

def cli(arguments: list[str], /) -> int: ...
