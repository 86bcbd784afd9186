"""Pictures of a page to be looked at: desktop, desktop in the dark, phone.

    python tests/bench/screens.py target/web/machine.html target/screens
    python tests/bench/screens.py target/demo/report.html target/screens

The live machine is shown after two seconds of its run; of a page that is higher than the window each window, up to MOST.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from browser import chromium, run, until  # noqa: E402

KINDS = {"desktop": (1400, 900, "light"), "dark": (1400, 900, "dark"), "phone": (390, 844, "light")}
MOST = 4


def main(page, folder):
    folder.mkdir(parents=True, exist_ok=True)
    chrome = chromium()
    for kind, (width, height, theme) in KINDS.items():
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        chrome.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        chrome.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": theme}]})
        chrome.get("about:blank")
        chrome.get(page.resolve().as_uri())
        if chrome.execute_script("return typeof machine !== 'undefined' && 'ready' in machine"):
            run(chrome, "await machine.ready")
            until(chrome, lambda: chrome.execute_script("return machine.time > 2"))
        for k in range(MOST):
            chrome.execute_script("window.scrollTo(0, arguments[0])", k * height)
            if chrome.execute_script("return Math.round(window.scrollY)") < k * height:
                break
            # Plots are drawn when they are seen.
            run(chrome, "await new Promise((turn) => setTimeout(turn, 2000))")
            file = folder / f"{page.stem}-{kind}-{k + 1}.png"
            chrome.save_screenshot(str(file))
            print(file)
    chrome.quit()


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
