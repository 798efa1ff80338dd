"""A real browser for tests and pictures of the cockpit."""

from __future__ import annotations

import os
import shutil
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from socketserver import BaseServer
from typing import Any, TypeVar

from hydrocrane.app.live import cockpit_server, viewer_server
from hydrocrane.app.serving.live_server import Files, Server
from hydrocrane.results.run import Run

AnyServer = TypeVar("AnyServer", bound=BaseServer)
# Names of browsers that understand Chromium's remote control.
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


class NoBrowser(Exception):
    """Why there is none."""


def installed() -> str | None:
    """Path of the browser that CHROMIUM names, or of one that is installed."""
    return os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, BROWSERS)), None)


@contextmanager
def chromium() -> Iterator[Any]:
    """A headless Chromium: one that is installed, or that playwright has downloaded."""
    try:
        from playwright.sync_api import Error, sync_playwright
    except ImportError as error:
        raise NoBrowser("playwright is not installed: pip install playwright") from error
    with sync_playwright() as playwright:
        # Inside containers the browser's own sandbox cannot be made; the page is the project's own.
        arguments = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
        try:
            browser = playwright.chromium.launch(executable_path=installed(), args=arguments)
        except Error as error:
            hint = "install Chromium, or run `playwright install chromium`"
            raise NoBrowser(f"no browser can be started ({hint}): {str(error).splitlines()[0]}") from error
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def served(target: str | Run | None = None) -> Iterator[str]:
    """Address of the cockpit, served in a thread, on a machine, scenario or run."""
    with answering(viewer_server(target) if isinstance(target, Run) else cockpit_server(target)) as server:
        yield server.address


@contextmanager
def hosted(files: Files) -> Iterator[Server]:
    """A web host of files, which can change: of the built page with its service worker, which `served` leaves out."""
    with answering(Server(files)) as server:
        yield server


@contextmanager
def answering(server: AnyServer) -> Iterator[AnyServer]:
    """A server that answers in a thread."""
    with server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


if __name__ == "__main__":
    sys.exit(installed() is None)
