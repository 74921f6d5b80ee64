"""The command ``comanip``; also ``python -m comanip``."""

from __future__ import annotations

import sys

from comanip.errors import ToolError

WRONG_USE = 2


def main() -> None:
    try:
        from comanip.cli import app
    except ModuleNotFoundError as error:
        if str(error.name).startswith("comanip"):
            raise
        package = str(error.name).split(".")[0]
        print(
            f"comanip: the package {package} is missing: run `make build` in the repository, or pip install {package}",
            file=sys.stderr,
        )
        sys.exit(WRONG_USE)
    try:
        app(prog_name="comanip")
    except ToolError as error:
        print(f"comanip: {error}", file=sys.stderr)
        sys.exit(WRONG_USE)


if __name__ == "__main__":
    main()
