"""The cockpit's page on this computer alone.

The page simulates in the browser; the server only hands out files. It knows them by name from the start, so that no
request reaches any other.
"""

from __future__ import annotations

import gzip
import hashlib
import mimetypes
import re
import socket
import sys
import threading
from collections.abc import Mapping
from contextlib import suppress
from functools import lru_cache
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import cast

from hydrocrane.errors import InputError

PAGE = Path(__file__).parents[1] / "cockpit_page"
HOST = "127.0.0.1"
POLICY = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; "
    "connect-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}
# A browser asks each time whether a file is still the same, but for those whose name holds a hash of what they are.
ASK, KEEP = "no-cache", "max-age=31536000, immutable"
HASHED = re.compile(r"/assets/.+-[\w-]{8,}\.\w+")
# Types that are worth compressing, with the level of gzip: 6 takes 0.1 s for the page and halves what 1 leaves.
PACKED = re.compile(r"text/|application/(json|wasm)")
LEVEL = 6
# What a computer's own list may lack or have otherwise.
TYPES = {".js": "text/javascript", ".wasm": "application/wasm", ".css": "text/css", ".html": "text/html; charset=utf-8"}
# The port that a browser leaves out of an address, and so out of the name of the host that it asks.
PLAIN_PORT = 80
# Connections served at once, and the longest that one may keep silent, s.
CONNECTIONS = 32
SILENCE = 10.0
# What keeps the page for times without a network: not where the next program may have the same address.
KEEPER = "/service-worker.js"
CHOSEN = "/chosen.json"
RECORDED = "/recorded.bin"

Files = Mapping[str, tuple[str, bytes]]


def page_files(folder: Path | None = None) -> dict[str, tuple[str, bytes]]:
    """Address to (type, content) of every file of the built page, in `folder` or where the package carries it."""
    folder = folder or PAGE
    if not (folder / "index.html").is_file():
        raise InputError(
            "the cockpit page is not built: run `make cockpit` in the project's folder, which needs Node.js, "
            "or install a wheel, which carries it"
        )
    files = {}
    for path in sorted(p for p in folder.rglob("*") if p.is_file()):
        kind = TYPES.get(path.suffix) or mimetypes.guess_type(path.name)[0] or "application/octet-stream"
        files["/" + path.relative_to(folder).as_posix()] = (kind, path.read_bytes())
    return {"/": files["/index.html"], **files}


def own_page(folder: Path | None = None) -> dict[str, tuple[str, bytes]]:
    """As `page_files`, for a program on this computer: the page knows it, and the browser keeps nothing of it."""
    files = page_files(folder)
    files.pop(KEEPER, None)
    for name in ("/", "/index.html"):
        kind, content = files[name]
        files[name] = (kind, content.replace(b"<html", b'<html data-served="live"', 1))
    return files


def host_names(port: int) -> set[str]:
    """What browsers call this computer when they ask for something at `port`."""
    names = {HOST, "localhost"}
    return {f"{name}:{port}" for name in names} | (names if port == PLAIN_PORT else set())


@lru_cache(maxsize=128)
def _tag(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:24]


@lru_cache(maxsize=128)
def _packed(content: bytes) -> bytes:
    return gzip.compress(content, LEVEL, mtime=0)


class Handler(BaseHTTPRequestHandler):
    """Answers GET and HEAD for the files it knows."""

    server: Server
    keeping = ASK
    timeout = SILENCE
    server_version = "hydrocrane"
    sys_version = ""

    def do_GET(self) -> None:
        self._answer(with_content=True)

    def do_HEAD(self) -> None:
        self._answer(with_content=False)

    def _answer(self, *, with_content: bool) -> None:
        # Another host's page whose name leads here must not read what is served.
        if self.headers.get("Host") not in self.server.hosts:
            return self.send_error(HTTPStatus.FORBIDDEN)
        name = self.path.partition("?")[0]
        found = self.server.files.get(name)
        if found is None:
            return self.send_error(HTTPStatus.NOT_FOUND)
        kind, content = found
        packed = PACKED.match(kind) is not None and self._takes_gzip()
        tag = f'"{_tag(content)}{"-gzip" if packed else ""}"'
        self.keeping = KEEP if HASHED.fullmatch(name) else ASK
        known = tag in (self.headers.get("If-None-Match") or "")
        self.send_response(HTTPStatus.NOT_MODIFIED if known else HTTPStatus.OK)
        self.send_header("ETag", tag)
        self.send_header("Vary", "Accept-Encoding")
        if not known:
            content = _packed(content) if packed else content
            if packed:
                self.send_header("Content-Encoding", "gzip")
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        if with_content and not known:
            self.wfile.write(content)
        return None

    def _takes_gzip(self) -> bool:
        codings = (coding.partition(";") for coding in (self.headers.get("Accept-Encoding") or "").split(","))
        shares = (share.partition("=")[2].strip() for name, _, share in codings if name.strip() == "gzip")
        return any(not share or re.match(r"1|0\.0*[1-9]", share) for share in shares)

    def end_headers(self) -> None:
        for name, value in {**HEADERS, "Cache-Control": self.keeping}.items():
            self.send_header(name, value)
        super().end_headers()

    def log_message(self, format: str, *args: object) -> None:
        """The terminal stays quiet."""


class Server(ThreadingHTTPServer):
    """A server on the loopback address. Of too many connections the oldest gives way."""

    daemon_threads = True
    request_queue_size = CONNECTIONS

    def __init__(self, files: Files, port: int = 0) -> None:
        try:
            super().__init__((HOST, port), Handler)
        except OSError as error:
            raise InputError(f"port {port} cannot be used ({error.strerror}); choose another with --port") from error
        self.files = files
        self.hosts = host_names(self.server_port)
        # Oldest first.
        self._connections: dict[socket.socket, None] = {}
        self._lock = threading.Lock()

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"http://{HOST}:{self.server_port}/" + ("?chosen" if CHOSEN in self.files else "")

    def process_request(self, request: socket.socket | tuple[bytes, socket.socket], client_address: object) -> None:
        with self._lock:
            if len(self._connections) >= CONNECTIONS:
                oldest = next(iter(self._connections))
                del self._connections[oldest]
                # Its thread then finds the end of what it reads.
                with suppress(OSError):
                    oldest.shutdown(socket.SHUT_RDWR)
            self._connections[cast(socket.socket, request)] = None
        super().process_request(request, client_address)

    def shutdown_request(self, request: socket.socket | tuple[bytes, socket.socket]) -> None:
        with self._lock:
            self._connections.pop(cast(socket.socket, request), None)
        super().shutdown_request(request)

    def handle_error(self, request: socket.socket | tuple[bytes, socket.socket], client_address: object) -> None:
        """Whoever goes away before the answer is there leaves nothing on the terminal."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)
