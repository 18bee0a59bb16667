"""`python -m scenarios` is the `remote-agent` command."""

from scenarios.cli import main

main()
