"""Drives the live machine's page in a browser, for its tests: the page paused, restarted, advanced, asked.

The page is `target/web/machine.html` (`cargo xtask web`), or what MACHINE_PAGE names.
"""

import os
from pathlib import Path

import pytest

from browser import chromium, noise, run
from conftest import FMU_DIR

PAGE = Path(os.environ.get("MACHINE_PAGE", FMU_DIR.parent / "web/machine.html")).resolve()


@pytest.fixture(scope="module")
def opened():
    """The browser, with the page as it opens."""
    assert PAGE.is_file(), f"no page {PAGE}; run `cargo xtask web`"
    chrome = chromium()
    chrome.get(PAGE.as_uri())
    yield chrome
    chrome.quit()


@pytest.fixture
def page(opened):
    """The page, paused, with no message from before."""
    run(opened, "await machine.ready; await machine.pause(); document.getElementById('message').textContent = ''")
    yield opened
    assert noise(opened) == []


def get(chrome, name, *ghost):
    return run(chrome, "return machine.get(...given)", name, *ghost)


def restart(chrome, **settings):
    """Paused at the start of a run with these settings; `__` stands for a dot."""
    run(chrome, "await machine.pause(); await machine.restart(given[0])", {k.replace("__", "."): v for k, v in settings.items()})


def reopen(chrome, address):
    chrome.get("about:blank")
    chrome.get(address)
    run(chrome, "await machine.ready")


def advance(chrome, seconds):
    run(chrome, "await machine.advance(given[0])", seconds)


def slide(chrome, label, value):
    """Moves a slider of the panel and lets it go."""
    chrome.execute_script(
        """
        const row = [...document.querySelectorAll("#panel .row")].find((row) => row.firstChild.textContent === arguments[0]);
        row.closest("details").open = true;
        const field = row.querySelector("input");
        field.value = arguments[1];
        field.dispatchEvent(new Event("input"));
        field.dispatchEvent(new Event("change"));
        """,
        label,
        value,
    )
