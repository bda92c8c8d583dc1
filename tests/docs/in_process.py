"""Commands of a page, run in the process of the tests: most of the time of a short one goes into imports."""

import contextlib
import io
from subprocess import CompletedProcess

import jaxtyping

from flexmodal.cli.main import main


def run(command, **options):
    """In the place of `subprocess.run`, in the working directory; types are checked in tests/cli."""
    _, *words = map(str, command)
    out, err, status = io.StringIO(), io.StringIO(), 0
    jaxtyping.config.update("jaxtyping_disable", True)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            main(words)
    except SystemExit as left:
        status = left.code
    finally:
        jaxtyping.config.update("jaxtyping_disable", False)
    return CompletedProcess(command, status, out.getvalue(), err.getvalue())
