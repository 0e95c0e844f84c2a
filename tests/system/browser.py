"""A page in headless Chromium, spoken to over its debugging pipe (file descriptors 3 and 4, messages of JSON ended by a zero byte)."""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import time


def program():
    """Of Chromium; None where there is none."""
    return next((p for p in map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome")) if p), None)


class Browser:
    def __enter__(self):
        self.profile = tempfile.TemporaryDirectory(prefix="twogrid_browser_")
        to_read, self.to = os.pipe()
        self.back, to_write = os.pipe()
        high = [os.dup(to_read) for _ in range(8)]  # so that neither end is 3 or 4 itself
        keep = (os.dup(to_read), os.dup(to_write))
        for fd in high:
            os.close(fd)
        self.process = subprocess.Popen([program(), "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--remote-debugging-pipe",
                                         "--user-data-dir=" + self.profile.name, "about:blank"], preexec_fn=lambda: (os.dup2(keep[0], 3), os.dup2(keep[1], 4)), close_fds=False,
                                        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        for fd in (to_read, to_write, *keep):
            os.close(fd)
        os.set_blocking(self.back, False)
        self.number, self.rest, self.events, self.session = 0, b"", [], None
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.ask(domain + ".enable")
        return self

    def __exit__(self, *_):
        self.process.terminate()
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self.to), os.close(self.back)
        self.profile.cleanup()

    def messages(self):
        try:
            self.rest += os.read(self.back, 1 << 20)
        except BlockingIOError:
            time.sleep(0.01)
        *whole, self.rest = self.rest.split(b"\0")
        return [json.loads(m) for m in whole]

    def ask(self, method, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters, **({"sessionId": self.session} if self.session else {})}
        os.write(self.to, json.dumps(message).encode() + b"\0")
        end, answer = time.time() + 30, None
        while answer is None and time.time() < end:
            for m in self.messages():
                if m.get("id") == self.number:
                    answer = m
                elif "method" in m:
                    self.events.append(m)
        if answer is None or "error" in answer:
            raise RuntimeError(f"{method}: {answer}")
        return answer["result"]

    def open(self, path, width, height):
        """Loads a file at this size of the window; what the console said and what was asked of the network."""
        self.events.clear()
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)
        url = pathlib.Path(path).as_uri()
        self.ask("Page.navigate", url=url)
        end = time.time() + 30
        while time.time() < end and self.evaluate("document.readyState") != "complete":
            time.sleep(0.05)
        self.evaluate("Promise.all([...document.images].map(i => i.decode().catch(() => 0))).then(() => 1)")
        said = [str(e["params"]) for e in self.events if e["method"] in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled") or
                (e["method"] == "Log.entryAdded" and e["params"]["entry"]["level"] in ("error", "warning"))]
        asked = [e["params"]["request"]["url"] for e in self.events if e["method"] == "Network.requestWillBeSent"]
        return said, [u for u in asked if not u.startswith(("data:", url))]

    def evaluate(self, expression):
        return self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)["result"].get("value")
