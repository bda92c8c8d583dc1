"""A WebSocket on a connection that the page's server has accepted; the protocol is websockets' own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from http.server import BaseHTTPRequestHandler
from typing import Any

Answer = Callable[[str], str]
"""From the text of a message to that of its answer."""

LARGEST = 1 << 20
"""Of a message [bytes]."""


def talk(handler: BaseHTTPRequestHandler, answer: Answer, origins: Sequence[str]) -> None:
    """Shake hands with a page and answer it until it hangs up.

    Args:
        handler: whose request asks for a WebSocket.
        answer: what is said to each message, one after the other.
        origins: where a page may come from; any other is refused with 403.
    """
    from websockets.datastructures import Headers
    from websockets.http11 import Request
    from websockets.server import ServerProtocol

    protocol = ServerProtocol(origins=[*origins], max_size=LARGEST)  # type: ignore[list-item]
    lines = [handler.requestline, *(f"{name}: {value}" for name, value in handler.headers.items())]
    protocol.receive_data("\r\n".join([*lines, "", ""]).encode("latin-1"))
    request = next((event for event in protocol.events_received() if isinstance(event, Request)), None)
    if request is None:
        handler.send_error(400)
        return
    response = protocol.accept(request)
    if response.status_code != 101:  # what is refused is said as the server says everything else
        handler.send_error(response.status_code)
        return
    response.headers = Headers(response.headers)
    protocol.send_response(response)
    handler.close_connection = True
    handler.connection.settimeout(None)  # a page may be silent for as long as somebody looks at it
    _flush(handler, protocol)
    while True:
        received = handler.rfile.read1(1 << 16)
        if received:
            protocol.receive_data(received)
        else:
            protocol.receive_eof()
        for event in protocol.events_received():
            _reply(protocol, event, answer)
        _flush(handler, protocol)
        if not received or protocol.close_expected():
            return


def _reply(protocol: Any, frame: Any, answer: Answer) -> None:
    from websockets.frames import Opcode

    if frame.opcode is not Opcode.TEXT or not frame.fin:
        return  # pages of ours send whole texts and nothing else
    protocol.send_text(answer(frame.data.decode("utf-8", "replace")).encode())


def _flush(handler: BaseHTTPRequestHandler, protocol: Any) -> None:
    for data in protocol.data_to_send():
        if data:
            handler.wfile.write(data)
