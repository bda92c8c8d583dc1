"""`flexmodal`: the group of commands, each imported only when it is called."""

from __future__ import annotations

import difflib
import importlib
import keyword
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.compiling import compilations_said
from flexmodal.cli.printing import plain, say
from flexmodal.cli.waiting import signs_of_life
from flexmodal.cli.width import NARROWEST, WIDEST, WIDTH

if TYPE_CHECKING:
    from flexmodal.errors import Fault

_COMMANDS = {
    "robots": "The robots that ship: joints, points, postures.",
    "check": "Is this URDF, card or campaign sound? Every fault at once.",
    "card": "A card for any URDF, its numbers guessed: card new ARM --out DIR.",
    "frf": "Receptance, mobility or inertance at a posture.",
    "modes": "Natural frequencies, damping ratios and shapes at a posture.",
    "measures": "Stiffness, mobility and receptance of a posture along a direction.",
    "optimise": "The posture that resists best.",
    "lobes": "Stability lobes of a milling cut, and postures by depth of cut.",
    "tune": "The operating frequency that vibrates least.",
    "path": "A posture for each point of a toolpath.",
    "atlas": "A sweep over many postures, kept as a Zarr store; goes on where it was stopped.",
    "lookup": "What an atlas has: near a posture, between postures, the best, a map.",
    "studies": "Published optimisations run again beside their printed numbers.",
    "campaign": "A campaign folder to fill in: campaign new ROBOT --out DIR.",
    "import": "Tables of measured data to a campaign, by a map that it drafts.",
    "fit": "Modal parameters of measured FRFs, with uncertainty.",
    "identify": "Stiffness, damping and inertia from a campaign, with uncertainty.",
    "predict": "The FRFs of a posture that nobody struck, with their band.",
    "diagnose": "What is missing in the model: name it, add it, show the gap shrink.",
    "rig": "A simulated hammer test, with effects hidden in it.",
    "show": "The robot, its modes or its deflection in the browser.",
    "export": "A posture for MuJoCo, python-control, ROS, KUKA or ABB.",
    "demo": "A tour: two robots, their FRFs, a better posture, a page.",
}

_LONGEST = 500
"""Characters of a complaint about the words of a call."""

_LONGEST_LINE = 1900
"""Characters of a line of any complaint; a fault is shorter by itself."""


SCHEMAS = Path(__file__).with_name("schemas")
"""What `--json` of each command gives, as JSON Schema."""


class _Commands(click.Group):
    """Commands named in a table and imported on use, so that --help is quick."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in _COMMANDS:
            return None
        own = f"{cmd_name}_" if keyword.iskeyword(cmd_name) else cmd_name
        module = importlib.import_module(f"flexmodal.cli.{own}")
        command: click.Command = getattr(module, own)
        for one in (command, *(command.commands.values() if isinstance(command, click.Group) else ())):
            if any(option.name == "width" for option in one.params):
                continue
            one.params.append(_width_option())
            schema = SCHEMAS / f"{cmd_name}.json"
            if any(option.name == "as_json" for option in one.params) and schema.is_file():
                one.params.append(_schema_option(schema))
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        name = args[0]
        if name not in _COMMANDS and not name.startswith("-"):
            ctx.fail(f"No such command {name!r}.{_meant(name)}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(_COMMANDS.items()))


def _meant(name: str) -> str:
    """The command that was meant, where one resembles the name."""
    close = difflib.get_close_matches(name, _COMMANDS, n=1)
    return f" Did you mean {close[0]!r}?" if close else f" The commands are {', '.join(_COMMANDS)}."


def _schema_option(schema: Path) -> click.Option:
    """`--json-schema`, which prints what `--json` gives and leaves."""

    def tell(context: click.Context, param: click.Parameter, asked: bool) -> None:
        if asked:
            click.echo(schema.read_text(encoding="utf-8"), nl=False)
            context.exit()

    return click.Option(
        ["--json-schema"],
        is_flag=True,
        is_eager=True,
        callback=tell,
        expose_value=False,
        help="The JSON Schema of --json.",
    )


def _width_option() -> click.Option:
    """`--width`, which every command takes and none is told of."""

    def keep(context: click.Context, param: click.Parameter, width: int | None) -> None:
        if width is not None:
            context.find_root().meta[WIDTH] = width

    return click.Option(
        ["--width"],
        type=click.IntRange(NARROWEST, WIDEST),
        callback=keep,
        expose_value=False,
        metavar="COLUMNS",
        help="Of tables and sentences; those of the terminal if none.",
    )


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="flexmodal")
def group() -> None:
    """Receptance, modes and the best posture of flexible-joint robots.

    ROBOT is a card's name (see `flexmodal robots`), a path to a robot.toml or a .urdf, or the name of an
    example arm. POSTURE is a named posture or q1=50deg,q2=-0.8 (radians unless deg).

    Exit status: 0 done, 1 the answer is no, 2 the request or its input is wrong.
    """


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and leave with its exit status; errors become sentences, never tracebacks."""
    from flexmodal.errors import FlexmodalError, InvalidInput, MissingExtra

    if arguments is None:
        _settle_in()
    try:
        with _pipes(), _signs(arguments):
            status: Any = group.main(arguments, prog_name="flexmodal", standalone_mode=False)
        sys.stdout.flush()
        sys.exit(status if isinstance(status, int) else 0)
    except InvalidInput as error:
        options = _options_of(arguments)
        _complain(*(str(_here(fault, options)) for fault in error.faults))
        sys.exit(2)
    except MissingExtra as error:
        _complain(str(error))
        sys.exit(2)
    except FlexmodalError as error:
        _complain(str(error))
        sys.exit(1)
    except click.ClickException as error:
        error.message = _short(error.message)  # type: ignore[misc]
        error.show()
        sys.exit(error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        _complain("interrupted")
        sys.exit(130)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        sys.exit(0)
    except OSError as error:
        _complain(f"{error.filename or 'standard output'}: {error.strerror or error}")
        try:
            sys.stdout.flush()
        except OSError:  # or the interpreter tries again at its end, and says so in its own words
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        sys.exit(2)


def _short(text: str) -> str:
    """What click quotes back, cut to what somebody reads and without what would steer the terminal."""
    return plain(text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…")


@contextmanager
def _pipes() -> Iterator[None]:
    """A reader that has enough is no failure; click leaves with 1 then, the pipe in a wrapper of its own."""
    before = sys.stdout
    try:
        yield
    except SystemExit as left:
        if left.code == 1 and sys.stdout is not before:
            raise BrokenPipeError from None
        raise


@contextmanager
def _signs(arguments: list[str] | None) -> Iterator[None]:
    """As the program of a process, say what is compiled, and that it works, unless told to be quiet."""
    if arguments is not None or "--quiet" in sys.argv:
        yield
        return
    with compilations_said(), signs_of_life():
        yield


def _settle_in() -> None:
    """As the program of a process: close in order when told to, and cope with any standard output."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # else scratch files would be left
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by the caller
            setattr(sys, name, Path(os.devnull).open("w"))  # noqa: SIM115 - for as long as the process
    if hasattr(sys.stdout, "reconfigure"):
        sys.stdout.reconfigure(errors="replace")  # a terminal without ° shows ?


def _options_of(arguments: list[str] | None) -> set[str]:
    """Options of the command that was called."""
    names = [name for name in (sys.argv[1:] if arguments is None else arguments) if name in _COMMANDS]
    command = _Commands().get_command(click.Context(group), names[0]) if names else None
    return set() if command is None else {option for one in command.params for option in one.opts}


def _here(fault: Fault, options: set[str]) -> Fault:
    """What the API calls a call came from the command line, and an argument perhaps from an option."""
    if fault.file != "call":
        return fault
    name, *rest = fault.key.split(" ")
    option = f"--{name.replace('_', '-')}"
    key = " ".join([option, *rest]) if option in options else fault.key
    return replace(fault, file="command line", key=key)


def _complain(*sentences: str) -> None:
    for sentence in sentences:
        lines = "\n".join(_cut(line) for line in sentence.splitlines())
        say(f"flexmodal: {lines}", err=True)


def _cut(line: str) -> str:
    """A line without its middle, where a name or a path of somebody else's made it long."""
    half = _LONGEST_LINE // 2
    return line if len(line) <= _LONGEST_LINE else f"{line[:half]}…{line[-half:]}"
