"""What is of the bridge's WebSocket alone: origins, bounds, programs that do not read, and what is no packet."""

from __future__ import annotations

import functools
import http.server
import sys
import threading
import time
import urllib.error
import urllib.request
from pathlib import Path

import pytest
from bridge_program import Program, bridge_alone, plant, served
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import hydrocrane as hc
from hydrocrane.app.serving import bridge_transport
from hydrocrane.app.serving.bridge import part_of, transport_of
from hydrocrane.app.serving.bridge_transport import Kind, Packet

# Of the page: whether the tip has risen so far.
RISES = """(height) => {
    const row = [...document.querySelectorAll("tr")].find((row) => row.textContent.includes("tip.z"));
    return Number(row.cells[1].textContent) > height;
}"""
HOWTO = Path(__file__).parents[3] / "docs/howto"


def test_pages_of_other_sites_are_refused():
    with served(plant(period="5 ms"), "ws") as (_, bridge):
        for origin in ("http://localhost:8000", "https://127.0.0.1", "http://[::1]:80"):
            with connect(bridge.address, origin=origin):
                pass
        for origin in ("https://crane.example", "null", "http://localhost.example", "http://127.0.0.1:80.example"):
            with pytest.raises(InvalidStatus, match="403"), connect(bridge.address, origin=origin):
                pass


def test_what_is_no_packet_changes_nothing():
    with served(plant(period="5 ms"), "ws", watchdog=5.0) as (program, bridge):
        program.send("text in place of a packet")
        assert "header of 32 bytes" in program.next(Kind.problem).text
        with connect(bridge.address) as other, pytest.raises(ConnectionClosed):
            other.send(bytes(70_000))
            other.recv(10.0)
        with pytest.raises(urllib.error.HTTPError, match="426"):
            urllib.request.urlopen(bridge.address.replace("ws://", "http://"), timeout=10.0)
        assert program.describe()["role"] == "plant"


def test_connections_are_counted(monkeypatch):
    monkeypatch.setattr(bridge_transport, "_CONNECTIONS", 2)
    with served(plant(period="5 ms"), "ws") as (_, bridge), connect(bridge.address):
        refused = connect(bridge.address)
        with refused, pytest.raises(ConnectionClosed, match="2 connections"):
            refused.recv(10.0)


def test_a_program_that_does_not_read_delays_nothing_and_takes_no_memory(monkeypatch):
    monkeypatch.setattr(bridge_transport, "_UNSENT", 8192)
    # The program reads 16 packets ahead and then no more.
    bridge_here = served(plant(period="1 ms"), "ws", watchdog=5.0)
    with bridge_here as (_, bridge), connect(bridge.address, max_queue=16, compression=None, close_timeout=0.2) as deaf:
        deaf.send(Packet(Kind.hello).packed())
        held = bridge._transport
        time.sleep(0.5)
        (connection,) = [c for peer, c in held._connections.items() if peer == bridge._client.peer]
        before = bridge.record.samples
        # The buffers of the system hold some megabytes: fill them, and see what is kept beyond.
        for _ in range(4000):
            held.send(bytes(8192), bridge._client.peer)
        time.sleep(0.5)
        assert 8192 <= connection.transport.get_write_buffer_size() < 3 * 8192
        assert bridge.record.samples > before + 50


def test_an_address_in_use_and_a_missing_package_are_one_message(monkeypatch):
    with served(plant(), "ws") as (_, bridge), pytest.raises(hc.InputError, match="cannot use ws://"):
        transport_of(bridge.address)
    monkeypatch.setitem(sys.modules, "websockets.asyncio.server", None)
    with pytest.raises(hc.InputError, match=r"hydrocrane\[websocket\]"):
        transport_of("ws://127.0.0.1:0")


def test_a_bridge_can_begin_again_on_its_port():
    with served(plant(), "ws") as (program, bridge):
        program.describe()
        address = bridge.address
    again = transport_of(address)
    assert str(again.address) == address
    again.close()


def test_a_program_that_has_gone_is_followed_by_another():
    with served(plant(period="5 ms"), "ws") as (program, bridge):
        program.describe()
        program.close()
        time.sleep(1.1)
        other = Program(bridge.address)
        assert other.describe()["role"] == "plant"
        other.close()


@pytest.mark.evidence
@pytest.mark.browser
def test_a_page_in_a_browser_drives_a_crane(browser):
    """The page of the how-to, as a browser runs it, from a server of this computer."""
    folder = functools.partial(http.server.SimpleHTTPRequestHandler, directory=HOWTO)
    pages = http.server.ThreadingHTTPServer(("127.0.0.1", 0), folder)
    threading.Thread(target=pages.serve_forever, daemon=True).start()
    part = part_of("tip-vertical-line", {})
    with bridge_alone(part, "ws") as bridge:
        page = browser.new_page()
        page.goto(f"http://localhost:{pages.server_address[1]}/bridge_client.html?bridge={bridge.address}")
        page.wait_for_function("document.querySelectorAll('#outputs td').length > 4")
        assert "crane with controller" in page.inner_text("#title")
        height = page.locator("tr", has_text="tip.z").locator("td").nth(1)
        page.wait_for_function("[...document.querySelectorAll('td')].every((cell) => cell.textContent)")
        before = float(height.inner_text())
        page.locator("input[name='stick.z']").fill("0.5")
        page.wait_for_function(RISES, arg=before + 0.01)
        assert not page.inner_text("#problem")
        page.close()
    pages.shutdown()
    pages.server_close()
