"""Served to this computer alone, and gone when it is over."""

import os
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path

import pytest
from flexmodal_viewer import close_all, show_robot
from flexmodal_viewer.serve import PageServer

from flexmodal.errors import InvalidRequest

linux_only = pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="reads /proc")


def listeners(pid):
    """Addresses a process and its children listen on, as /proc has them."""
    inodes = set()
    for process in [pid, *children(pid)]:
        for entry in Path(f"/proc/{process}/fd").iterdir():
            try:
                target = os.readlink(entry)
            except OSError:
                continue
            if target.startswith("socket:["):
                inodes.add(target[8:-1])
    found = []
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[3] == "0A" and fields[9] in inodes:
                found.append(fields[1])
    return found


def children(pid):
    text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(child) for child in text.split()]


def get(url, host=None):
    request = urllib.request.Request(url, headers={"Host": host} if host else {})
    return urllib.request.build_opener(urllib.request.ProxyHandler({})).open(request, timeout=10)


def port_of(url):
    return urllib.parse.urlsplit(url).port


@linux_only
def test_listens_on_the_loopback_alone(fanuc):
    before = listeners(os.getpid())
    url = show_robot(
        fanuc, fanuc.posture("configuration_1"), open_browser=False, announce=lambda _: None, block=False
    )
    try:
        new = [address for address in listeners(os.getpid()) if address not in before]
        port = port_of(url)
        assert new == [f"0100007F:{port:04X}"]  # 127.0.0.1, and nothing besides
        assert b"<!DOCTYPE html>" in get(url).read(100)
    finally:
        close_all()
    assert listeners(os.getpid()) == before


def test_answers_for_its_own_name_and_page_only():
    with PageServer("<p>page</p>") as server:
        server.start()
        assert get(server.url).read() == b"<p>page</p>"
        assert get(server.url + "?x=1").status == 200
        port = port_of(server.url)
        assert get(server.url, f"localhost:{port}").status == 200
        for url, host in (
            (f"http://127.0.0.1:{port}/", None),
            (f"http://127.0.0.1:{port}/guessed/", None),
            (server.url + "etc/passwd", None),
            (server.url, "evil.example"),
            (server.url, f"evil.example:{port}"),
        ):
            with pytest.raises(urllib.error.HTTPError) as caught:
                get(url, host)
            caught.value.close()


def test_a_taken_port_is_refused():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InvalidRequest, match=str(port)):
            PageServer("", port=port)


@pytest.mark.parametrize("port", [-1, 65536])
def test_ports_out_of_range_are_refused(port):
    with pytest.raises(InvalidRequest):
        PageServer("", port=port)


def test_the_port_asked_for_is_used_and_freed():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    for _ in range(2):  # the second time it must be free again
        with PageServer("x", port=port) as server:
            server.start()
            assert server.url.startswith(f"http://127.0.0.1:{port}/")
            assert get(server.url).read() == b"x"


_SCRIPT = """
import flexmodal_viewer
from flexmodal.model import load
robot = load("fanuc_s360")
print(flexmodal_viewer.show_robot(
    robot, robot.posture("configuration_1"), open_browser=False, announce=lambda text: print(text, flush=True)
))
"""


@pytest.fixture
def ctrl_c():
    """Children heed Ctrl-C: what a shell runs in the background ignores it, and its children would too."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@linux_only
def test_it_ends_when_whoever_called_it_is_killed(tmp_path):
    """A shell, an editor or a test killed with SIGKILL cannot tell its child to end."""
    script = tmp_path / "serve.py"
    script.write_text(_SCRIPT)
    caller = f"import subprocess, sys; subprocess.run([sys.executable, {str(script)!r}])"
    process = subprocess.Popen([sys.executable, "-c", caller], stdout=subprocess.PIPE, text=True)
    try:
        url = process.stdout.readline().split()[2]
        (server,) = children(process.pid)
        assert get(url).status == 200
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
    until = time.monotonic() + 30
    while Path(f"/proc/{server}").exists() and time.monotonic() < until:
        time.sleep(0.1)
    with pytest.raises(OSError, match="refused"):
        get(url)


@pytest.mark.parametrize("hosts", [[], ["own", "own"], ["own", "evil.example"], ["evil.example", "own"]])
def test_one_host_is_named_and_it_is_its_own(hosts):
    with PageServer("<p>page</p>") as server:
        server.start()
        port = port_of(server.url)
        path = server.url.split(str(port))[1]
        lines = [f"Host: {f'127.0.0.1:{port}' if host == 'own' else host}\r\n" for host in hosts]
        with socket.create_connection(("127.0.0.1", port), timeout=10) as line:
            line.sendall(f"GET {path} HTTP/1.1\r\n{''.join(lines)}Connection: close\r\n\r\n".encode())
            answer = line.makefile("rb").read()
    assert b" 421 " in answer.split(b"\r\n")[0]
    assert b"page" not in answer.split(b"\r\n\r\n")[1]


def test_every_answer_says_what_it_may_load():
    with PageServer("<p>page</p>") as server:
        server.start()
        for path, status in (("", 200), ("elsewhere", 404)):
            try:
                answer = get(server.url + path)
            except urllib.error.HTTPError as error:
                answer = error
            with answer:
                assert answer.status == status
                assert answer.headers["Content-Security-Policy"].startswith("default-src 'none'")


@linux_only
@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_nothing_outlives_it(ending):
    process = subprocess.Popen([sys.executable, "-c", _SCRIPT], stdout=subprocess.PIPE, text=True)
    try:
        line = process.stdout.readline()
        url = line.split()[2]
        assert url.startswith("http://127.0.0.1:")
        assert get(url).status == 200
        assert all(address.startswith("0100007F:") for address in listeners(process.pid))
        assert children(process.pid) == []
        process.send_signal(ending)
        rest, _ = process.communicate(timeout=60)
    finally:
        process.kill()
        process.wait()
    if ending == signal.SIGINT:
        assert process.returncode == 0
        assert rest.strip() == url
    with pytest.raises(OSError, match="refused"):
        get(url)


def test_meshcat_and_its_server_are_never_imported():
    # Importing meshcat opens a ZeroMQ context and brings its server within reach.
    script = (
        "import sys, flexmodal_viewer; from flexmodal.model import load; r = load('fanuc_s360'); "
        "from flexmodal_viewer.page import page_html; "
        "page_html(flexmodal_viewer.robot_scene(r, r.posture('configuration_1'))); "
        "print(sorted({'meshcat', 'zmq', 'tornado', 'IPython'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
