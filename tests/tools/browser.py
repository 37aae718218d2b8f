"""Headless Chromium driven over its DevTools pipe: the standard library alone, no port, no WebSocket."""
import base64
import fcntl
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

FLAGS = ["--headless=new", "--no-first-run", "--disable-extensions", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--no-default-browser-check", "--hide-scrollbars",
         "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--host-resolver-rules=MAP * ~NOTFOUND"]


PROGRAM = shutil.which("chromium") or shutil.which("chromium-headless-shell")


class Browser:
    def __init__(self, flags=FLAGS):
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        to_read, self.out = os.pipe()
        self.inp, to_write = os.pipe()
        ends = [fcntl.fcntl(fd, fcntl.F_DUPFD, 10) for fd in (to_read, to_write)]
        root = ["--no-sandbox"] if os.geteuid() == 0 else []
        with open(os.path.join(self.profile.name, "log"), "wb") as log:
            self.process = subprocess.Popen(
                [PROGRAM, *flags, *root, f"--user-data-dir={self.profile.name}", "--remote-debugging-pipe", "about:blank"],
                pass_fds=(3, 4), preexec_fn=lambda: [os.dup2(fd, 3 + i) for i, fd in enumerate(ends)],
                stdin=subprocess.DEVNULL, stdout=log, stderr=log)  # it reads commands from 3, answers on 4
        for fd in (to_read, to_write, *ends):
            os.close(fd)
        self.rest, self.number, self.events = b"", 0, []
        target = next(t for t in self.call("Target.getTargets")["targetInfos"] if t["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.page(domain + ".enable")

    def message(self):
        while b"\0" not in self.rest:
            data = os.read(self.inp, 1 << 20)
            if not data:
                raise RuntimeError("the browser has ended")
            self.rest += data
        text, self.rest = self.rest.split(b"\0", 1)
        return json.loads(text)

    def call(self, method, session=None, **params):
        self.number += 1
        text = {"id": self.number, "method": method, "params": params}
        if session:
            text["sessionId"] = session
        os.write(self.out, json.dumps(text).encode() + b"\0")
        while True:
            answer = self.message()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            if "method" in answer:
                self.events.append(answer)

    def page(self, method, **params):
        return self.call(method, self.session, **params)

    def value(self, text):
        answer = self.page("Runtime.evaluate", expression=text, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(json.dumps(answer["exceptionDetails"])[:400])
        return answer["result"].get("value")

    def size(self, width, height, scale=1, mobile=False):
        self.page("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=mobile)
        self.page("Emulation.setTouchEmulationEnabled", enabled=mobile, maxTouchPoints=5)

    def open(self, path, ready="document.documentElement?.dataset.ready === 'yes'", limit=120):
        began = time.perf_counter()
        self.page("Page.navigate", url=pathlib.Path(path).resolve().as_uri())
        while not self.value(ready):
            if time.perf_counter() - began > limit:
                raise RuntimeError("not ready: " + json.dumps(self.trouble())[:500])
            time.sleep(0.02)
        return time.perf_counter() - began

    def picture(self, path):
        data = self.page("Page.captureScreenshot", format="png", captureBeyondViewport=False)["data"]
        pathlib.Path(path).write_bytes(base64.b64decode(data))

    def mouse(self, kind, x, y, **more):
        self.page("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1, **more)

    def click(self, x, y):
        self.mouse("mousePressed", x, y, buttons=1)
        self.mouse("mouseReleased", x, y)

    def touch(self, kind, *places):
        """touchStart, touchMove or touchEnd, with the places of all fingers that are down."""
        self.page("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)])

    def swipe(self, *ways, steps=10):
        """Fingers, each from (x0, y0) to (x1, y1), together."""
        for i in range(steps + 1):
            places = [(x0 + (x1 - x0) * i / steps, y0 + (y1 - y0) * i / steps) for x0, y0, x1, y1 in ways]
            self.touch("touchMove" if i else "touchStart", *places)
        self.touch("touchEnd")

    def drag(self, x0, y0, x1, y1, steps=10):
        self.mouse("mousePressed", x0, y0, buttons=1)
        for i in range(1, steps + 1):
            self.mouse("mouseMoved", x0 + (x1 - x0) * i / steps, y0 + (y1 - y0) * i / steps, buttons=1)
        self.mouse("mouseReleased", x1, y1)

    def trouble(self):
        """What the page said on its console, threw, or asked of a network."""
        found = []
        for event in self.events:
            p, name = event["params"], event["method"]
            if name == "Runtime.consoleAPICalled" and p["type"] in ("error", "warning", "assert"):
                found.append(["console", p["args"][0].get("value", p["args"][0].get("description"))])
            elif name == "Runtime.exceptionThrown":
                found.append(["exception", p["exceptionDetails"]["text"]])
            elif name == "Log.entryAdded" and p["entry"]["level"] in ("error", "warning"):
                found.append(["log", p["entry"]["text"]])
            elif name == "Network.requestWillBeSent" and not p["request"]["url"].startswith(("file:", "data:", "blob:", "about:")):
                found.append(["request", p["request"]["url"]])
        return found

    def close(self):
        try:
            self.call("Browser.close")
        except (RuntimeError, OSError):
            pass
        self.process.wait(20)
        self.profile.cleanup()


STEPS = "for (let i = 0; i < 100; ++i) quoin.show(i % quoin.frames)"
SHOWN = """(() => { const start = performance.now(), n = 2, gl = quoin.renderer.getContext(), pixel = new Uint8Array(4);
    for (let i = 0; i < n; ++i) {
      quoin.show(Math.floor(i * quoin.frames / n));
      quoin.draw();
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);  // waits for the picture
    }
    const {triangles, calls} = quoin.renderer.info.render;
    return [(performance.now() - start) / n, triangles, calls]; })()"""


def measure(path):
    """How fast a page of `quoin view` opens and goes through its times."""
    browser = Browser()
    browser.page("Performance.enable", timeDomain="threadTicks")
    browser.size(1280, 800)

    def used():
        return next(m["value"] for m in browser.page("Performance.getMetrics")["metrics"] if m["name"] == "ThreadTime")

    opened, opening = browser.open(path, limit=600), used()
    browser.value(STEPS)
    stepped = 10 * (used() - opening)
    shown, triangles, calls = browser.value(SHOWN)
    print(f"opens in {opened:.1f} s, {opening:.2f} s of the processor; a time: {stepped:.1f} ms of the processor for JavaScript, {triangles} "
          f"triangles in {calls} draws, {shown:.0f} ms until the picture is there; {browser.trouble() or 'no error, no request'}")
    browser.close()


if __name__ == "__main__":  # browser.py PAGE
    measure(sys.argv[1])
