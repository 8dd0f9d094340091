"""`python -m egad`: the same as the command `egad`."""

from egad.cli import main

if __name__ == "__main__":
    main()
