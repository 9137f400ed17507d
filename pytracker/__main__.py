"""`python -m pytracker`."""

from pytracker.cli import main

if __name__ == "__main__":
    main()
