"""A page served from memory until Ctrl-C, on 127.0.0.1 unless another address is asked for."""

from __future__ import annotations

import ipaddress
import os
import secrets
import socket
import threading
import webbrowser
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from flexmodal.errors import Fault, InvalidRequest
from flexmodal_viewer.socket_talk import Answer, talk

HOST = "127.0.0.1"
"""The address listened on unless another is named: whoever is not on this computer cannot ask."""

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "worker-src blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
SOCKET = "socket"
"""Where the page asks for its WebSocket, behind its own address."""

_open: list[PageServer] = []


class _Left(Exception):
    """Whoever called this program has gone."""


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False
    caller: int | None = None
    """Process that this one ends with; none if it serves in the background of another's work."""

    def server_bind(self) -> None:
        # The base class asks the name service what 127.0.0.1 is called, which can take long.
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # not kept waiting by its last run
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()
        self.server_name, self.server_port = str(self.server_address[0]), int(self.server_address[1])

    def service_actions(self) -> None:
        """Looked at between requests: whether whoever called this program is still there."""
        if self.caller is not None and os.getppid() != self.caller:
            raise _Left

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that hangs up early is no error."""


class PageServer:
    """One page at one address. A context: the port is free again when it ends."""

    def __init__(
        self, page: str, *, port: int | None = None, host: str = HOST, answer: Answer | None = None
    ) -> None:
        """Listen on a port, a free one if none is given.

        The address holds a token that is new each time: another program of this computer, or a page from
        elsewhere in the same browser, would have to guess it.

        Args:
            page: the HTML.
            port: on which to listen.
            host: one address of this computer, as numbers.
            answer: what is said to the page's messages; without it there is no WebSocket.

        Raises:
            InvalidRequest: the port is taken, out of range, or not ours to use, or the address is none of
                this computer's.
        """
        number = 0 if port is None else port
        if not 0 <= number <= 65535:
            raise InvalidRequest(Fault("call", "port", str(number), "0 to 65535; 0 for a free one"))
        if not _is_one_address(host):
            allowed = f"one address of this computer, such as {HOST}"
            raise InvalidRequest(Fault("call", "host", repr(host), allowed))
        token = secrets.token_urlsafe(16)
        try:
            handler = _handler(page.encode(), f"/{token}/", host, answer)
            self._server = _Server((host, number), handler, bind_and_activate=False)
            self._server.server_bind()
            self._server.server_activate()
        except OSError as error:
            self._server.server_close()
            allowed = "a port that is free, or none to have one chosen"
            found = f"{number} of {host}, {error.strerror}" if host != HOST else f"{number}, {error.strerror}"
            raise InvalidRequest(Fault("call", "port", found, allowed)) from None
        self.url = f"http://{host}:{self._server.server_port}/{token}/"
        self._thread: threading.Thread | None = None

    def __enter__(self) -> PageServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def run(self) -> None:
        """Serve until Ctrl-C or until whoever called this program has gone, then close."""
        self._server.caller = os.getppid()
        try:
            self._server.serve_forever(poll_interval=0.2)
        except (KeyboardInterrupt, _Left):
            pass
        finally:
            self._server.server_close()

    def start(self) -> None:
        """Serve in a thread that ends with this process at the latest."""
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop serving and free the port."""
        if self._thread is not None:
            self._server.shutdown()
            self._thread.join()
            self._thread = None
        self._server.server_close()


def serve(
    page: str,
    *,
    port: int | None,
    open_browser: bool,
    announce: Callable[[str], None],
    block: bool,
    host: str = HOST,
    answer: Answer | None = None,
) -> str:
    """Serve a page and return its address.

    Args:
        page: the HTML.
        port: port to listen on; a free one if none.
        open_browser: open it in the user's browser.
        announce: told the address, and how to end it.
        block: wait for Ctrl-C; otherwise return at once and serve until `close_all` or the end.
        host: address to listen on; of any but 127.0.0.1 it is said that others can reach it.
        answer: what is said to the page's messages.
    """
    server = PageServer(page, port=port, host=host, answer=answer)
    if host != HOST:
        announce(f"Warning: whoever can reach {host} and learns the address below can see this page.")
    announce(f"Showing at {server.url}" + (" (Ctrl-C ends it)" if block else ""))
    if not block:
        server.start()
        _open.append(server)
    if open_browser:
        threading.Thread(target=webbrowser.open, args=(server.url,), daemon=True).start()
    if block:
        server.run()
    return server.url


def close_all() -> None:
    """Stop every page that is served in the background."""
    while _open:
        _open.pop().close()


def _is_one_address(host: str) -> bool:
    """Whether it is one IPv4 address; 0.0.0.0 would be all of them, and no browser could name it."""
    try:
        found = ipaddress.IPv4Address(host)
    except ValueError:
        return False
    return not (found.is_unspecified or found.is_multicast)


def _handler(page: bytes, root: str, host: str, answer: Answer | None) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        server: _Server
        timeout = 30
        protocol_version = "HTTP/1.1"  # which a WebSocket needs; each connection has one request all the same

        def do_GET(self) -> None:
            self._answer(with_body=True)

        def do_HEAD(self) -> None:
            self._answer(with_body=False)

        def _answer(self, *, with_body: bool) -> None:
            # A name that somebody else's site resolves to 127.0.0.1 is not ours to answer to.
            own = (host, "localhost") if host == HOST else (host,)
            names = {f"{name}:{self.server.server_port}" for name in own}
            asked = self.headers.get_all("Host", [])
            self.close_connection = True
            if len(asked) != 1 or asked[0] not in names:
                self.send_error(421)
                return
            path = self.path.partition("?")[0]
            if (
                answer is not None
                and with_body
                and secrets.compare_digest(path.encode(), f"{root}{SOCKET}".encode())
            ):
                talk(self, answer, [f"http://{name}" for name in names])
                return
            if not secrets.compare_digest(path.encode(), root.encode()):
                self.send_error(404)
                return
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Content-Length", str(len(page)))
            self.send_header("Cache-Control", "no-store")
            self.send_header("Connection", "close")
            self.end_headers()
            if with_body:
                self.wfile.write(page)

        def end_headers(self) -> None:
            """Every answer says what it may load, those that say no too; the page says more itself."""
            self.send_header("Content-Security-Policy", POLICY)
            self.send_header("Referrer-Policy", "no-referrer")
            self.send_header("X-Content-Type-Options", "nosniff")
            super().end_headers()

        def version_string(self) -> str:
            return "flexmodal"

        def log_message(self, format: str, *args: object) -> None:
            """Say nothing."""

    return Handler
