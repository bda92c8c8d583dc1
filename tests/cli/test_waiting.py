"""What a terminal shows while a command works; nothing of it elsewhere."""

import fcntl
import io
import os
import pty
import re
import struct
import subprocess
import sys
import termios
import time

import pytest

from flexmodal.cli import waiting
from flexmodal.cli.printing import busy, print_json, progress, say, stages
from flexmodal.cli.waiting import hush, signs_of_life


class Terminal(io.StringIO):
    """Standard error as a terminal has it."""

    def isatty(self):
        return True

    def screen(self):
        """What is to be seen in the end: \\r and a move up go back."""
        lines, row, column = [""], 0, 0
        text = self.getvalue()
        while text:
            if text.startswith("\x1b[A"):
                row, text = max(row - 1, 0), text[3:]
                continue
            sign, text = text[0], text[1:]
            if sign == "\n":
                row, column = row + 1, 0
                lines += [""] * (row + 1 - len(lines))
            elif sign == "\r":
                column = 0
            else:
                lines[row] = lines[row][:column].ljust(column) + sign + lines[row][column + 1 :]
                column += 1
        return "\n".join(line.rstrip() for line in lines).rstrip("\n")


@pytest.fixture
def in_terminal(monkeypatch):
    """Called in the test itself: pytest puts its own standard error in place after the fixtures."""

    def made():
        terminal = Terminal()
        monkeypatch.setattr(sys, "stderr", terminal)
        monkeypatch.setattr(waiting, "PATIENCE", 0.05)
        return terminal

    return made


def until(there, seconds=20):
    """Wait for something another thread does."""
    end = time.monotonic() + seconds
    while not there():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_command_without_a_bar_says_that_it_works(in_terminal):
    terminal = in_terminal()
    with signs_of_life():
        until(lambda: "working 00:" in terminal.getvalue())
        say("said meanwhile", err=True)
    assert terminal.screen() == "said meanwhile"


def test_a_bar_takes_its_place(in_terminal):
    terminal = in_terminal()
    with signs_of_life():
        until(lambda: "working" in terminal.getvalue())
        before = terminal.getvalue().count("working")
        with busy("fitting", quiet=False):
            say("warning: a thing", err=True)
            time.sleep(1.3)  # more than one turn of the watch
        assert terminal.getvalue().count("working") == before
        assert "fitting 00:" in terminal.getvalue()
    assert terminal.screen() == "warning: a thing"


def test_a_stage_that_takes_long_shows_its_clock(in_terminal):
    terminal = in_terminal()
    with stages(quiet=False) as advance:
        advance("looking", 0.0)
        until(lambda: re.search(r"looking.*00:0[1-9]", terminal.getvalue(), re.DOTALL))
    assert terminal.screen() == ""


def test_who_waits_for_the_user_says_nothing(in_terminal):
    terminal = in_terminal()
    with signs_of_life():
        hush()
        time.sleep(0.3)
    assert terminal.getvalue() == ""


def test_nothing_off_a_terminal_nor_where_quiet_is_asked(monkeypatch, capsys):
    monkeypatch.setattr(waiting, "PATIENCE", 0.0)
    with signs_of_life(), stages(quiet=False) as advance, progress(2, "steps", quiet=False) as step:
        advance("one", 0.5)
        step()
        time.sleep(0.1)
        print_json({"a": 1})
    assert capsys.readouterr() == ('{"a": 1}\n', "")


def read_all(terminal):
    """Till the other side is closed, which Linux says by an error."""
    found = b""
    while True:
        try:
            part = os.read(terminal, 65536)
        except OSError:
            break
        if not part:
            break
        found += part
    return found.decode()


def test_a_program_in_a_terminal():
    """The first second is over before anything is imported here; an answer comes after the sign is gone."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    code = (
        "import sys, time; from flexmodal.cli import waiting, main, modes;"
        "waiting.PATIENCE = 0.1; from flexmodal.cli import options; load = options.RobotOptions.load;"
        "options.RobotOptions.load = lambda self: (time.sleep(1.0), load(self))[1];"
        "sys.argv = ['flexmodal', 'modes', 'six_link', '--posture', 'start_2', '--json']; main.main()"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=theirs) as process:
        os.close(theirs)
        shown = read_all(ours)
        out = process.stdout.read()
    os.close(ours)
    assert process.returncode == 0
    assert out.startswith(b'{"modes"')
    assert "working 00:0" in shown
    assert "Traceback" not in shown
