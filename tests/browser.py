"""A Chromium or Firefox without a network and a screen, for pages that open from a folder.

Needs Chromium and ChromeDriver of the system, and Firefox with Xvfb (Debian: chromium, chromium-driver, firefox-esr, xvfb). Where there are none tests are
skipped, except with REPORT_BROWSER=required in the environment, as in CI.
"""

import base64
import importlib.resources
import json
import os
import shutil
import socket
import subprocess
import tempfile
import time
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.common.exceptions import TimeoutException
from selenium.webdriver.support.ui import WebDriverWait

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
# Advice of Chromium on speed (software renderer, a canvas of plotly.js that is read back) is no error.
ADVICE = ("GPU stall", "willReadFrequently")


def lacks(browser, packages):
    """Ends a test that has no browser."""
    missing = f"no {browser} on this machine (Debian: apt-get install {packages})"
    if os.environ.get("REPORT_BROWSER") == "required":
        pytest.fail(missing)
    pytest.skip(missing)


def chromium(*flags):
    """A driver of the browser; whoever asks for it quits it."""
    binary = next(filter(None, map(shutil.which, BROWSERS)), None)
    driver = shutil.which("chromedriver")
    if not (binary and driver):
        lacks("Chromium with ChromeDriver", "chromium chromium-driver")
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


class Marionette:
    """Selenium's commands in the words of Firefox's own remote protocol, so that no geckodriver is needed: JSON messages, each after its
    length, as [0, number, command, parameters] and [1, number, error, result]."""

    # Commands that are called otherwise than Selenium does, without "WebDriver:".
    NAMES = {
        "get": "Navigate",
        "w3cExecuteScript": "ExecuteScript",
        "w3cExecuteScriptAsync": "ExecuteAsyncScript",
        "actions": "PerformActions",
        "clickElement": "ElementClick",
        "sendKeysToElement": "ElementSendKeys",
        "getCurrentUrl": "GetCurrentURL",
        "screenshot": "TakeScreenshot",
        "findChildElement": "FindElement",
        "findChildElements": "FindElements",
        "getElementValueOfCssProperty": "GetElementCSSValue",
    }

    def __init__(self, binary, screen):
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        # No port is chosen beforehand: another test could take it.
        preferences = {"marionette.port": 0, "network.proxy.type": 1, "network.proxy.http": "0.0.0.0", "network.proxy.ssl": "0.0.0.0"}
        folder = Path(self.profile.name)
        (folder / "user.js").write_text("".join(f"user_pref({json.dumps(name)}, {json.dumps(value)});\n" for name, value in preferences.items()))
        command = [binary, "--marionette", "--remote-allow-system-access", "--no-remote", "--width=1400", "--height=1000", "--profile", folder]
        # Without a screen Firefox draws nothing in three dimensions. The screen tells its own number.
        reading, writing = os.pipe()
        self.screen = subprocess.Popen([screen, "-displayfd", str(writing), "-screen", "0", "1400x1000x24"], pass_fds=[writing], stderr=subprocess.DEVNULL)
        os.close(writing)
        with open(reading) as told:
            environment = os.environ | {"DISPLAY": f":{told.readline().strip()}"}
        self.process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        port = folder / "MarionetteActivePort"
        while not (port.is_file() and port.read_text()):
            if self.process.poll() is not None:
                raise RuntimeError(f"{binary} ended with {self.process.returncode} before it listened")
            time.sleep(0.05)
        self.stream = socket.create_connection(("127.0.0.1", int(port.read_text()))).makefile("rwb")
        self.count = 0
        self.read()

    def read(self):
        length = b""
        while (digit := self.stream.read(1)) != b":":
            if not digit:
                raise RuntimeError("Firefox has closed the connection")
            length += digit
        return json.loads(self.stream.read(int(length)))

    def ask(self, command, parameters):
        self.count += 1
        message = json.dumps([0, self.count, command, parameters]).encode()
        self.stream.write(b"%d:%s" % (len(message), message))
        self.stream.flush()
        return self.read()[2:]

    def execute(self, command, parameters):
        """As Selenium's connection does."""
        if command == "quit":
            self.ask("Marionette:Quit", {"flags": ["eForceQuit"]})
            return {"value": None}
        parameters = {name: value for name, value in (parameters or {}).items() if name != "sessionId"}
        element = parameters.pop("id", None)
        name = self.NAMES.get(command, command[0].upper() + command[1:])
        if command == "newSession":
            parameters = parameters["capabilities"]["alwaysMatch"]
        elif command.startswith("findChild"):
            parameters["element"] = element
        elif element is not None:
            parameters["id"] = element
        error, result = self.ask(f"WebDriver:{name}", parameters)
        if error:
            return {"status": error["error"], "value": error}
        # What is no answer of several parts comes as {"value": …}.
        return {"value": result["value"] if isinstance(result, dict) and result.keys() == {"value"} else result}

    def close(self):
        self.stream.close()
        self.process.wait()
        self.screen.terminate()
        self.screen.wait()
        self.profile.cleanup()

    def complaints(self):
        """Errors and warnings of scripts since this was asked last."""
        self.ask("Marionette:SetContext", {"value": "chrome"})
        script = """const found = Services.console.getMessageArray().filter((m) => m instanceof Ci.nsIScriptError && /^(file|blob|data):/.test(m.sourceName));
        Services.console.reset();
        return found.map((m) => m.toString());"""
        _, result = self.ask("WebDriver:ExecuteScript", {"script": script, "args": []})
        self.ask("Marionette:SetContext", {"value": "content"})
        return result["value"]


def firefox():
    """A driver of Firefox; whoever asks for it quits it."""
    binary, screen = shutil.which("firefox-esr") or shutil.which("firefox"), shutil.which("Xvfb")
    if not (binary and screen):
        lacks("Firefox with Xvfb", "firefox-esr xvfb")
    driver = webdriver.Remote(command_executor=Marionette(binary, screen), options=webdriver.FirefoxOptions())
    driver.set_script_timeout(600)
    return driver


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
    try:
        return WebDriverWait(chrome, 300, 0.05).until(lambda _: condition())
    except TimeoutException:
        said = chrome.execute_script("return ['message', 'broken-text', 'clock'].map((id) => document.getElementById(id)?.innerText ?? '')")
        raise AssertionError(f"it never came; the page says {said}") from None


def pictured(chrome):
    """Waits until the window has shown what the page's state was when this was called; no picture comes while a script advances the run."""
    run(chrome, "await new Promise((rested) => setTimeout(rested, 100)); await new Promise((shown) => requestAnimationFrame(() => requestAnimationFrame(shown)))")


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
    if chrome.name == "firefox":
        return chrome.command_executor.complaints()
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
