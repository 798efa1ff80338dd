"""The bridge over WebSocket, for programs in a browser: one binary message is one packet."""

from __future__ import annotations

import asyncio
import logging
import queue
import re
import socket
import threading
from typing import TYPE_CHECKING

from hydrocrane.app.bridge_transport import LARGEST, Address, Peer, bound
from hydrocrane.errors import InputError

if TYPE_CHECKING:
    from websockets.asyncio.server import Server, ServerConnection

# Connections at a time; only one program uses the bridge, the others are told so.
_CONNECTIONS = 16
# Packets that wait for the bridge, and bytes that wait for a slow program. More are lost, as datagrams are.
_WAITING = 1024
_UNSENT = 256 * 1024
# Time that a program has to agree to the end, s.
_GOODBYE = 0.5

# Any page that is open in a browser could connect to this computer; only pages of this computer may. Other programs
# send no origin.
_ORIGINS = [None, re.compile(r"https?://(localhost|127\.0\.0\.1|\[::1\])(:\d+)?")]

# Failed handshakes are the business of who asks for the log.
_LOG = logging.getLogger(__name__)
_LOG.addHandler(logging.NullHandler())


class WebSocket:
    """A server with a thread of its own, so that a slow connection never delays a sample.

    Raises
    ------
    InputError
        The address cannot be had, or the package `websockets` is missing.
    """

    def __init__(self, address: Address) -> None:
        try:
            import websockets.asyncio.server
        except ImportError:
            raise InputError("ws:// needs the package websockets; install hydrocrane[websocket]") from None
        self._websockets = websockets.asyncio.server
        self._socket = bound(address, socket.SOCK_STREAM)
        host, port = self._socket.getsockname()[:2]
        self.address = Address("ws", host, port)
        self._packets: queue.Queue[tuple[bytes, Peer]] = queue.Queue(_WAITING)
        self._connections: dict[Peer, ServerConnection] = {}
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._server = asyncio.run_coroutine_threadsafe(self._opened(), self._loop).result()

    async def _opened(self) -> Server:
        serve = self._websockets.serve
        # Compression would cost more time than packets of some hundred bytes are worth.
        return await serve(
            self._handle,
            sock=self._socket,
            origins=_ORIGINS,
            compression=None,
            max_size=LARGEST,
            close_timeout=_GOODBYE,
            logger=_LOG,
        )

    async def _handle(self, connection: ServerConnection) -> None:
        if len(self._connections) >= _CONNECTIONS:
            await connection.close(1013, f"the bridge has {_CONNECTIONS} connections")
            return
        peer = (connection.remote_address[0], connection.remote_address[1])
        self._connections[peer] = connection
        try:
            async for message in connection:
                data = message.encode() if isinstance(message, str) else bytes(message)
                if not self._packets.full():
                    self._packets.put_nowait((data, peer))
        finally:
            del self._connections[peer]

    def receive(self, wait: float) -> tuple[bytes, Peer] | None:
        try:
            return self._packets.get(timeout=wait) if wait > 0 else self._packets.get_nowait()
        except queue.Empty:
            return None

    def send(self, data: bytes, peer: Peer) -> None:
        self._loop.call_soon_threadsafe(self._push, data, peer)

    def _push(self, data: bytes, peer: Peer) -> None:
        connection = self._connections.get(peer)
        if connection is not None and connection.transport.get_write_buffer_size() < _UNSENT:
            self._websockets.broadcast([connection], data)

    def close(self) -> None:
        async def closed() -> None:
            self._server.close()
            await self._server.wait_closed()

        asyncio.run_coroutine_threadsafe(closed(), self._loop).result()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
