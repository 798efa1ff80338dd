"""The server of the page takes what a browser never sends."""

from __future__ import annotations

import time
from types import SimpleNamespace

import pytest

from hydrocrane.app.serving.live_server import Handler


def takes_gzip(coding):
    return Handler._takes_gzip(SimpleNamespace(headers={"Accept-Encoding": coding}))


@pytest.mark.parametrize(
    ("coding", "taken"),
    [
        ("gzip", True),
        ("br , gzip;q=0.5", True),
        ("deflate,gzip ; q=1.0", True),
        ("gzip;q=0", False),
        ("gzip;q=0.000", False),
        ("br", False),
        ("xgzip", False),
        ("", False),
    ],
)
def test_what_a_browser_takes(coding, taken):
    assert takes_gzip(coding) is taken


@pytest.mark.parametrize(
    "coding", [" " * 60_000 + "x", "gzip" + " " * 60_000 + "x", "," * 60_000, "gzip;q=0." + "0" * 60_000]
)
def test_a_long_header_holds_nothing_up(coding):
    began = time.process_time()
    assert not takes_gzip(coding)
    assert time.process_time() - began < 0.5
