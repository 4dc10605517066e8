"""Opens a report in a headless Chromium and uses it as a user would.

look.py CHROMIUM CHROMEDRIVER REPORT.html FOLDER

The script writes screenshots to FOLDER and prints one JSON object with the contents of the page and
the messages of the console. It uses WebDriver, which is JSON over HTTP.
"""

import base64
import json
import pathlib
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

chromium, chromedriver, report, folder = sys.argv[1:]
folder = pathlib.Path(folder)

FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--force-device-scale-factor=1",
]


def call(method, url, body=None):
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(url, data, {"Content-Type": "application/json"}, method=method)
    try:
        with urllib.request.urlopen(request, timeout=120) as answer:
            return json.load(answer)["value"]
    except urllib.error.HTTPError as error:
        raise SystemExit(f"{method} {url}: {error.read().decode()}")


def start(driver):
    """The address of the driver as soon as it listens."""
    for line in driver.stdout:
        if "started successfully on port" in line:
            return "http://127.0.0.1:" + line.rstrip().rstrip(".").rsplit(" ", 1)[1]
    raise SystemExit("chromedriver did not start")


class Browser:
    def __init__(self, address, flags, size):
        options = {"binary": chromium, "args": flags + [f"--window-size={size[0]},{size[1]}"]}
        capabilities = {"goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        made = call("POST", address + "/session", {"capabilities": {"alwaysMatch": capabilities}})
        self.url = f"{address}/session/{made['sessionId']}"

    def open(self, path):
        call("POST", self.url + "/url", {"url": pathlib.Path(path).resolve().as_uri()})

    def script(self, text):
        # Wait until the next frame has been drawn.
        body = (
            "const done = arguments[arguments.length - 1];"
            f"const value = (() => {{ {text} }})();"
            "requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(() => done(value), 30)));"
        )
        return call("POST", self.url + "/execute/async", {"script": body, "args": []})

    def shot(self, name):
        picture = base64.b64decode(call("GET", self.url + "/screenshot"))
        (folder / f"{name}.png").write_bytes(picture)

    def media(self, scheme):
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        command = {"cmd": "Emulation.setEmulatedMedia", "params": {"features": features}}
        call("POST", self.url + "/goog/cdp/execute", command)

    def size(self, width, height):
        """The size of the page, which a window does not go below 500 pixels of."""
        params = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        command = {"cmd": "Emulation.setDeviceMetricsOverride", "params": params}
        call("POST", self.url + "/goog/cdp/execute", command)

    def keys(self, *keys):
        steps = [{"type": kind, "value": key} for key in keys for kind in ("keyDown", "keyUp")]
        call("POST", self.url + "/actions", {"actions": [{"type": "key", "id": "k", "actions": steps}]})

    def pointer(self, steps, kind="mouse"):
        source = {"type": "pointer", "id": kind, "parameters": {"pointerType": kind}, "actions": steps}
        call("POST", self.url + "/actions", {"actions": [source]})
        call("DELETE", self.url + "/actions")

    def wheel(self, x, y, amount):
        step = {"type": "scroll", "x": x, "y": y, "deltaX": 0, "deltaY": amount, "duration": 50}
        call("POST", self.url + "/actions", {"actions": [{"type": "wheel", "id": "w", "actions": [step]}]})

    def click(self, selector):
        self.script(f"document.querySelector({json.dumps(selector)}).click()")

    def log(self):
        entries = call("POST", self.url + "/se/log", {"type": "browser"})
        # This concerns the screenshots: software rendering is read back slowly.
        ours = "GPU stall due to ReadPixels"
        return [entry["message"] for entry in entries if ours not in entry["message"]]

    def close(self):
        call("DELETE", self.url)


def move(x, y, ms=0):
    return {"type": "pointerMove", "x": round(x), "y": round(y), "duration": ms}


TAB, ENTER, LEFT = "\ue004", "\ue007", "\ue012"

# What is cut off: letters outside of their drawing, boxes outside of the window, boxes that would have to be
# scrolled sideways.
CLIPPED = """
    const out = [];
    const name = e => `${e.tagName} ${e.id} ${e.getAttribute("class") ?? ""} ${e.textContent.trim().slice(0, 30)}`;
    for (const letters of document.querySelectorAll("svg text")) {
      const [own, all] = [letters, letters.ownerSVGElement].map(e => e.getBoundingClientRect());
      if (own.width && (own.left < all.left - 1 || own.right > all.right + 1 || own.bottom > all.bottom + 1))
        out.push(name(letters));
    }
    for (const box of document.querySelectorAll("body *")) {
      if (box.closest(".unseen, svg, canvas")) continue;
      const { left, right, width } = box.getBoundingClientRect();
      if (width && (left < -1 || right > innerWidth + 1 || box.scrollWidth > box.clientWidth + 1 && box.clientWidth
          && getComputedStyle(box).overflowX !== "visible")) out.push(name(box));
    }
    return out;
"""

# What a screen reader could not name.
UNNAMED = """
    const all = s => [...document.querySelectorAll(s)];
    const named = e => e.getAttribute("aria-label") || e.labels?.length || e.textContent.trim();
    return [
      ...all("button, input, summary").filter(e => !named(e)),
      ...all("canvas, svg, [role=region], [role=group]").filter(e => !e.getAttribute("aria-label")),
      ...all("canvas, svg").filter(e => e.getAttribute("role") !== "img"),
      ...all("table").filter(e => !e.caption),
      ...all("th").filter(e => !e.scope || !e.textContent.trim()),
      ...all("img").filter(e => !e.alt),
    ].map(e => e.outerHTML.slice(0, 90));
"""

# The element that has the focus, and whether a line around it is visible.
FOCUSED = """
    const e = document.activeElement, style = getComputedStyle(e);
    if (e === document.body) return ["", false];
    const name = e.id || e.dataset.side || e.dataset.hole || e.dataset.place || e.name || e.ariaLabel || e.textContent.trim();
    return [name, style.outlineStyle !== "none" && parseFloat(style.outlineWidth) > 0];
"""


def stops(browser):
    """What the tab key reaches from the beginning of the page, in turn."""
    browser.script("window.scrollTo(0, 0); document.querySelector('h1').tabIndex = -1; document.querySelector('h1').focus()")
    found = []
    while len(found) < 200:
        browser.keys(TAB)
        name, outlined = browser.script(FOCUSED)
        if not name or [name, outlined] in found[:1]:
            break
        found.append([name, outlined])
    return found


def with_keys(browser):
    """Looks at the page with the keyboard alone."""
    found = {"stops": stops(browser)}
    browser.script("document.getElementById('view').focus()")
    browser.script("document.getElementById('viewer').scrollIntoView()")
    browser.shot("keys-before")
    browser.keys(LEFT, LEFT, LEFT)
    browser.script("")
    browser.shot("keys-turned")
    told = "return document.getElementById('said').textContent"
    found["sides"] = []
    for key in "1234560":
        browser.keys(key)
        found["sides"].append(browser.script(told))
        browser.shot(f"side-{key}")
    browser.keys(ENTER)
    found["middle"] = browser.script(told)
    browser.script("document.querySelector('.place').focus({ preventScroll: true })")
    found["pinned"] = browser.script("return document.querySelector('#worst span').textContent")
    browser.script("document.activeElement.blur()")
    return found


def sizes(browser):
    """What is cut off on a desktop and on a telephone, with the tables of the histograms open."""
    browser.script("document.querySelectorAll('details').forEach(d => { d.open = true; })")
    found = {}
    for width in (1400, 820, 390):
        browser.size(width, 900)
        for colours in ("signed", "distance"):
            browser.click(f"input[value={colours}]")
            found[f"{width} {colours}"] = browser.script(CLIPPED)
        browser.click("input[value=signed]")
        browser.shot(f"wide-{width}")
    browser.size(1400, 900)
    return found


DOWN = {"type": "pointerDown", "button": 0}
UP = {"type": "pointerUp", "button": 0}


def look(browser):
    browser.media("light")
    browser.open(report)
    browser.script("document.getElementById('viewer').scrollIntoView()")
    browser.shot("front")
    box = browser.script(
        "const r = document.getElementById('view').getBoundingClientRect();"
        "return [r.left + r.width / 2, r.top + r.height / 2, r.width, r.height]"
    )
    x, y = box[:2]
    browser.pointer([move(x, y), DOWN, move(x + 140, y + 40, 100), UP])
    browser.script("")
    browser.shot("turned")
    browser.wheel(round(x), round(y), -400)
    browser.script("")
    browser.shot("near")
    browser.click("[data-side=overview]")
    browser.script("")
    browser.shot("reset")
    browser.pointer([move(x, y), DOWN, move(x - 120, y, 100), UP], "touch")
    browser.script("")
    browser.shot("touched")
    browser.click("[data-side=overview]")
    browser.click("input[value=distance]")
    browser.shot("distance")
    browser.click("input[value=smoothed]")
    browser.shot("smoothed")
    browser.click("#show-scan")
    browser.click("#show-face")
    browser.shot("face")
    browser.click("#show-net")
    browser.shot("net")
    browser.click("#show-net")
    browser.click("input[value=curvature]")
    browser.shot("curvature")
    curvature = browser.script(
        "return document.querySelector('#legend svg').getAttribute('aria-label')"
    )
    browser.click("input[value=zebra]")
    browser.shot("zebra")
    browser.click("input[value=plain]")
    browser.click("#show-net")
    for name in ["#show-scan", "#show-face", "#show-net", "input[value=signed]", "input[value=measured]"]:
        browser.click(name)
    # The number under the pointer, a little beside the centre if there is a hole.
    readouts = []
    for dx in (0, 90, -90, 160, -160):
        browser.pointer([move(x + dx, y + dx / 3), move(x + dx + 1, y + dx / 3)])
        readouts.append(browser.script(
            "const r = document.getElementById('readout'); return r.hidden ? null : r.textContent"
        ))
    browser.script("document.querySelector('.hole')?.focus({ preventScroll: true })")
    browser.shot("hole")
    browser.script("document.activeElement.blur()")
    browser.media("dark")
    browser.script("")
    browser.shot("dark")
    browser.click("#theme")
    browser.shot("light-again")
    browser.script("window.scrollTo(0, 0)")
    browser.shot("top")
    browser.script("document.querySelector('.cards').scrollIntoView()")
    browser.shot("cards")
    browser.click("#copy")
    keys, clipped = with_keys(browser), sizes(browser)
    return browser.script(
        """
        const all = s => [...document.querySelectorAll(s)];
        return {
          title: document.title, heading: document.querySelector("h1").textContent,
          live: document.getElementById("viewer").classList.contains("live"),
          holes: all(".hole").length, loops: all(".plane .loop").length,
          worst: document.querySelector("#worst span").textContent,
          histograms: all(".histogram").filter(h => h.getBoundingClientRect().width > 0).length,
          scripts: all("script").length, wide: document.documentElement.scrollWidth > innerWidth,
          requests: performance.getEntriesByType("resource").map(r => r.name).filter(n => !n.startsWith("data:")),
          unplanted: window.planted === undefined,
          command: document.getElementById("command-line").textContent,
          copied: document.getElementById("copy").textContent,
        }"""
    ) | {
        "readouts": readouts,
        "curvature": curvature,
        "keys": keys,
        "clipped": clipped,
        "unnamed": browser.script(UNNAMED),
    }


def main():
    folder.mkdir(parents=True, exist_ok=True)
    command = [chromedriver, "--port=0"]
    driver = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    said = {}
    try:
        address = start(driver)
        with tempfile.TemporaryDirectory() as profile:
            browser = Browser(address, FLAGS + [f"--user-data-dir={profile}"], (1400, 1000))
            said = look(browser)
            said["console"] = browser.log()
            browser.close()
            time.sleep(0.3)
        with tempfile.TemporaryDirectory() as profile:
            # A small window without WebGL.
            off = [f for f in FLAGS if "swiftshader" not in f] + ["--disable-3d-apis"]
            browser = Browser(address, off + [f"--user-data-dir={profile}"], (500, 900))
            browser.open(report)
            said["still"] = browser.script(
                "const i = document.getElementById('still');"
                "return i.naturalWidth > 100 && i.getBoundingClientRect().width > 100"
                " && !document.getElementById('refused').hidden"
            )
            browser.shot("still")
            said["console"] += browser.log()
            browser.close()
            time.sleep(0.3)
    finally:
        driver.kill()
    print(json.dumps(said))


main()
