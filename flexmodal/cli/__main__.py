"""`python -m flexmodal.cli`."""

from flexmodal.cli.main import main

main()
