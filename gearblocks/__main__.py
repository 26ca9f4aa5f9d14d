"""The shell as `python -m gearblocks`."""

from gearblocks.cli.main import main

if __name__ == "__main__":
    raise SystemExit(main())
