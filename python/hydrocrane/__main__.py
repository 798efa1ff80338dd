"""``python -m hydrocrane`` is the command line."""

from hydrocrane.app.cli import main

if __name__ == "__main__":
    main()
