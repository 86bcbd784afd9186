"""A headless Chromium without a network, for pages that open from a folder.

Needs Chromium and ChromeDriver of the system (Debian: chromium, chromium-driver). Where there are none tests are skipped, except with
REPORT_BROWSER=required in the environment, as in CI.
"""

import base64
import importlib.resources
import os
import shutil
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.support.ui import WebDriverWait

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
# Advice of Chromium on speed (software renderer, a canvas of plotly.js that is read back) is no error.
ADVICE = ("GPU stall", "willReadFrequently")


def chromium(*flags):
    """A driver of the browser; whoever asks for it quits it."""
    binary = next(filter(None, map(shutil.which, BROWSERS)), None)
    driver = shutil.which("chromedriver")
    if not (binary and driver):
        missing = "no Chromium with ChromeDriver on this machine (Debian: apt-get install chromium chromium-driver)"
        if os.environ.get("REPORT_BROWSER") == "required":
            pytest.fail(missing)
        pytest.skip(missing)
    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for flag in (
        "headless=new",
        "no-sandbox",
        "disable-dev-shm-usage",
        "use-angle=swiftshader",
        "enable-unsafe-swiftshader",
        "disable-background-networking",
        "disable-component-update",
        "disable-sync",
        "no-first-run",
        "window-size=1400,1000",
        # Nothing is reachable: the page must do without.
        "host-resolver-rules=MAP * ~NOTFOUND",
        *flags,
    ):
        options.add_argument(f"--{flag}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    chrome = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    chrome.set_script_timeout(600)
    return chrome


def webkit():
    """A driver of WebKit, the other engine that Debian has with one (webkit2gtk-driver), which needs a screen: `xvfb-run`."""
    options = webdriver.WebKitGTKOptions()
    options.binary_location = next(str(path) for path in Path("/usr/lib").glob("*/webkit2gtk-4.*/MiniBrowser"))
    options.add_argument("--automation")
    driver = webdriver.WebKitGTK(options=options, service=webdriver.WebKitGTKService(shutil.which("WebKitWebDriver")))
    driver.set_script_timeout(600)
    return driver


def until(chrome, condition):
    """Waits for it. How long is no measure: a page that never gets there ends the wait, a busy machine does not."""
    return WebDriverWait(chrome, 300, 0.05).until(lambda _: condition())


def shown(chrome, name):
    """The text of the element of that id, also of one that fades away."""
    return chrome.execute_script("return document.getElementById(arguments[0]).innerText", name)


def drop(chrome, name, content):
    """A file falls onto the page."""
    chrome.execute_script(
        """
        const bytes = Uint8Array.from(atob(arguments[1]), (c) => c.charCodeAt(0));
        const data = new DataTransfer();
        data.items.add(new File([bytes], arguments[0]));
        document.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
        """,
        name,
        base64.b64encode(content).decode(),
    )


def noise(chrome):
    """What the browser has complained of since this was asked last."""
    if chrome.name != "chrome":
        return []  # It has no such list.
    return [e for e in chrome.get_log("browser") if e["level"] != "INFO" and not any(a in e["message"] for a in ADVICE)]


def run(chrome, script, *arguments):
    """What the lines of an asynchronous function return; its errors are `RuntimeError`s."""
    done = chrome.execute_async_script(
        f"const given = [...arguments], told = given.pop(); (async () => {{ {script} }})().then((v) => told([v]), (e) => told([null, e.message]))",
        *arguments,
    )
    if len(done) == 2:
        raise RuntimeError(done[1])
    return done[0]


def downloaded(chrome, button):
    """The text that a click on this button would keep as a file."""
    chrome.execute_script(
        """
        const made = URL.createObjectURL;
        URL.createObjectURL = (blob) => { window.kept = blob; URL.createObjectURL = made; return "data:,"; };
        document.getElementById(arguments[0]).click();
        """,
        button,
    )
    return run(chrome, "return kept.text()")


def remarks(chrome):
    """What axe-core says against the page: rule, what it is about, and the elements; in its light and its dark colours."""
    script = (importlib.resources.files("axe_core_python") / "axe.min.js").read_text()
    chrome.execute_script(script)
    found = []
    for theme in ("light", "dark"):
        chrome.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": theme}]})
        # Plots are plotly.js's own, and many.
        violations = (
            "const { violations } = await axe.run({ exclude: ['.js-plotly-plot'] });"
            "return violations.map(({ id, help, nodes }) => [id, help, nodes.map((node) => node.html.slice(0, 160))])"
        )
        found += [[theme, *remark] for remark in run(chrome, violations)]
    chrome.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": ""}]})
    return found
