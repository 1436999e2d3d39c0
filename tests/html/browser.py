"""Chromium without a window, driven through its DevTools protocol.

The protocol runs over a pair of pipes, so there is no port that two tests could want at once. Nothing here needs more
than Python's standard library.
"""

import base64
import ctypes
import json
import os
import select
import shutil
import signal
import subprocess
import tempfile
import time

_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36
_LIBC = ctypes.CDLL(None, use_errno=True)

_FLAGS = [
    "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--disable-extensions", "--disable-crash-reporter",
    "--disable-breakpad", "--disable-dev-shm-usage", "--hide-scrollbars", "--mute-audio", "--window-size=1280,800",
    "--remote-debugging-pipe",
]
# WebGL on the processor: test machines have no graphics card.
_SOFTWARE_GL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
_WITHOUT_GL = ["--disable-3d-apis"]


class PageError(Exception):
    """A page did what a good one does not: a script failed, or it wanted something from a network."""


class Browser:
    """One Chromium with one page. A context manager: its processes and its folder are gone afterwards, also when a test
    fails, and the processes when this one is killed.

    program: path of Chromium. webgl: False for a browser without it. timeout: s, for each answer.
    """

    def __init__(self, program, webgl=True, timeout=120):
        self.timeout = timeout
        self.problems = []
        self.requests = []
        self._next = 0
        self._answers = {}
        self._buffer = b""
        self._folder = tempfile.mkdtemp(prefix="handhold-chromium-")
        # What the browser starts and leaves behind becomes a child of this process, and can be waited for.
        _LIBC.prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
        to_browser, self._write = os.pipe()
        self._read, from_browser = os.pipe()
        command = [program, *_FLAGS, *(_SOFTWARE_GL if webgl else _WITHOUT_GL), "--user-data-dir=" + self._folder,
                   "about:blank"]

        def prepare():
            _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
            # The browser reads from 3 and writes to 4, whatever numbers the pipes have here.
            source, target = os.dup(to_browser), os.dup(from_browser)
            source, target = (os.dup(source) if source == 4 else source), (os.dup(target) if target == 3 else target)
            os.dup2(source, 3)
            os.dup2(target, 4)

        environment = dict(os.environ, HOME=self._folder, DBUS_SESSION_BUS_ADDRESS="disabled:")
        self._log = open(os.path.join(self._folder, "log"), "wb")
        try:
            self._process = subprocess.Popen(command, preexec_fn=prepare, close_fds=False, start_new_session=True,
                                             stdin=subprocess.DEVNULL, stdout=self._log, stderr=self._log,
                                             env=environment)
        except OSError:
            self._log.close()
            shutil.rmtree(self._folder, ignore_errors=True)
            raise
        finally:
            os.close(to_browser)
            os.close(from_browser)
        try:
            targets = self._call("Target.getTargets", session=None)["targetInfos"]
            page = next(target for target in targets if target["type"] == "page")
            self._session = None
            self._session = self._call("Target.attachToTarget", session=None, targetId=page["targetId"],
                                       flatten=True)["sessionId"]
            for domain in ("Page", "Runtime", "Log", "Network"):
                self.call(domain + ".enable")
        except BaseException:
            self.close()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    # ---- The protocol ----

    def call(self, method, **parameters):
        """Sends a command to the page and returns its result."""
        return self._call(method, session=self._session, **parameters)

    def _call(self, method, session, **parameters):
        self._next += 1
        message = {"id": self._next, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        deadline = time.monotonic() + self.timeout
        while self._next not in self._answers:
            self._take(deadline)
        answer = self._answers.pop(self._next)
        if "error" in answer:
            raise PageError("%s: %s" % (method, answer["error"]["message"]))
        return answer["result"]

    def _take(self, deadline):
        left = deadline - time.monotonic()
        if left <= 0 or not select.select([self._read], [], [], left)[0]:
            raise TimeoutError("Chromium has not answered within %g s; its log: %s" % (self.timeout, self._log_text()))
        bytes_read = os.read(self._read, 1 << 20)
        if not bytes_read:
            raise PageError("Chromium has ended; its log: " + self._log_text())
        *messages, self._buffer = (self._buffer + bytes_read).split(b"\0")
        for text in messages:
            message = json.loads(text)
            if "id" in message:
                self._answers[message["id"]] = message
            else:
                self._event(message["method"], message["params"])

    def _event(self, method, parameters):
        if method == "Page.loadEventFired":
            self._loaded = True
        elif method == "Runtime.exceptionThrown":
            details = parameters["exceptionDetails"]
            self.problems.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning", "assert"):
            self.problems.append("console: " + " ".join(str(a.get("value", a)) for a in parameters["args"]))
        elif method == "Log.entryAdded" and parameters["entry"]["level"] in ("error", "warning"):
            self.problems.append("log: " + parameters["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])

    def _log_text(self):
        with open(self._log.name, "rb") as log:
            return log.read()[-2000:].decode(errors="replace")

    # ---- The page ----

    def open(self, path, states=("ready",)):
        """Opens a file, waits until it says that it is in one of the states, and returns its state.

        Raises PageError when a script fails, the console has an error or warning, or anything but the file is asked
        for.
        """
        self.problems, self.requests, self._loaded = [], [], False
        url = "file://" + path.replace("%", "%25").replace("?", "%3F").replace("#", "%23")
        self.call("Page.navigate", url=url)
        deadline = time.monotonic() + self.timeout
        while not self._loaded:
            self._take(deadline)
        state = self.wait("document.documentElement.dataset.state", lambda s: s not in (None, "loading"))
        self.check()
        if state not in states:
            raise PageError("the page's state is %r" % state)
        return state

    def check(self):
        """Raises PageError for what has gone wrong since open()."""
        error = self.evaluate("document.documentElement.dataset.error")
        if error:
            self.problems.append("the page says: " + error)
        # Swiftshader tells of its own slowness.
        problems = [p for p in self.problems if "GPU stall due to ReadPixels" not in p]
        if problems:
            raise PageError("; ".join(problems))
        others = [url for url in self.requests if not url.startswith(("file://", "blob:null"))]
        if len([url for url in self.requests if url.startswith("file://")]) > 1 or others:
            raise PageError("more than the page was loaded: %s" % self.requests)

    def evaluate(self, expression):
        """The value of a JavaScript expression."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            details = answer["exceptionDetails"]
            raise PageError(details.get("exception", {}).get("description", details["text"]))
        return answer["result"].get("value")

    def wait(self, expression, good):
        """Asks until good(value); returns the value."""
        deadline = time.monotonic() + self.timeout
        while True:
            value = self.evaluate(expression)
            if good(value):
                return value
            if time.monotonic() > deadline:
                raise TimeoutError("%s stays %r" % (expression, value))
            time.sleep(0.03)

    def settle(self):
        """Waits until the picture is still; returns what the page says that it has drawn."""
        # What was just pressed has had its effect after two frames.
        still = """new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() =>
          done(document.documentElement.dataset.still === "true"))))"""
        deadline = time.monotonic() + self.timeout
        while True:
            if self.evaluate(still):
                return json.loads(self.evaluate("document.documentElement.dataset.drawn"))
            if time.monotonic() > deadline:
                raise TimeoutError("the picture does not come to rest")

    # ---- A person's hands ----

    def place_of(self, selector):
        """The middle of an element (px of the window), scrolled into view."""
        box = self.evaluate("""(() => {
          const e = document.querySelector(%s);
          e.scrollIntoView({block: "nearest"});
          const {x, y, width, height} = e.getBoundingClientRect();
          return [x + width / 2, y + height / 2];
        })()""" % json.dumps(selector))
        return box[0], box[1]

    def mouse(self, kind, x, y, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def click(self, x, y, count=1):
        for n in range(1, count + 1):
            self.mouse("mousePressed", x, y, button="left", buttons=1, clickCount=n)
            self.mouse("mouseReleased", x, y, button="left", clickCount=n)

    def click_on(self, selector):
        self.click(*self.place_of(selector))

    def drag(self, start, end, button="left", steps=5):
        buttons = {"left": 1, "right": 2}[button]
        self.mouse("mousePressed", *start, button=button, buttons=buttons, clickCount=1)
        for i in range(1, steps + 1):
            x, y = (a + (b - a) * i / steps for a, b in zip(start, end))
            self.mouse("mouseMoved", x, y, button=button, buttons=buttons)
        self.mouse("mouseReleased", *end, button=button, clickCount=1)

    def wheel(self, x, y, down):
        self.mouse("mouseWheel", x, y, deltaX=0, deltaY=down)

    def fingers(self, *steps):
        """Each step is a list of places (px); the fingers go from one to the next and are lifted at the end."""
        for i, places in enumerate(steps):
            points = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(places)]
            self.call("Input.dispatchTouchEvent", type="touchMove" if i else "touchStart", touchPoints=points)
        self.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def key(self, key):
        text = {"text": key} if len(key) == 1 else {}
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, **text,
                  windowsVirtualKeyCode={"Escape": 27, "End": 35, "Home": 36, "ArrowLeft": 37, "ArrowUp": 38,
                                         "ArrowRight": 39, "ArrowDown": 40}.get(key, 0))
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key)

    def screen(self, width, height, ratio=1, mobile=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=ratio,
                  mobile=mobile)
        self.call("Emulation.setTouchEmulationEnabled", enabled=mobile)

    def screenshot(self):
        """PNG bytes."""
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])

    # ---- The end ----

    def processes(self):
        """Ids of all processes of this browser's group, or with its folder on their command line."""
        found = []
        for name in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open("/proc/%s/cmdline" % name, "rb") as line, open("/proc/%s/stat" % name, "rb") as stat:
                    state, _, group = stat.read().rpartition(b")")[2].split()[:3]
                    ours = int(group) == self._process.pid or self._folder.encode() in line.read()
                    if state != b"Z" and ours:
                        found.append(int(name))
            except OSError:
                continue
        return found

    def close(self):
        """Ends the browser and all that it started, and removes its folder."""
        if self._process is None:
            return
        deadline = time.monotonic() + 30
        ended = set()
        while time.monotonic() < deadline:
            left = self.processes()
            ended.update(left)
            for process in left:
                try:
                    os.kill(process, signal.SIGKILL)
                except ProcessLookupError:
                    pass
            # A dead process can be waited for only when all of its threads are dead.
            ended = {process for process in ended if not self._gone(process)}
            if not left and not ended:
                break
            time.sleep(0.02)
        self._process.wait()
        self._process = None
        os.close(self._read)
        os.close(self._write)
        self._log.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _gone(self, process):
        """Whether nothing is left of a process that was killed, not even the entry that waits for its parent."""
        if process == self._process.pid:
            return self._process.poll() is not None
        try:
            return os.waitpid(process, os.WNOHANG)[0] != 0
        except ChildProcessError:
            # Its parent is still another one that dies, too; or all is over.
            return not os.path.exists("/proc/%d" % process)
