"""``python -m foldrs`` is the command line, where its script is not on the path."""

from foldrs.cli import main

if __name__ == "__main__":
    main()
