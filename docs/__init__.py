"""Pages that a program writes: tables of README.md, the pages of config and those of papers."""
