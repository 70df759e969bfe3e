"""Drives Chromium without a window, over a pipe: the part of its protocol that the checks of pages need, without a package.

The protocol is that of https://chromedevtools.github.io/devtools-protocol/: JSON objects, each ended by a zero byte.
"""
from __future__ import annotations

import base64
import fcntl
import json
import os
import re
import select
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any, Optional

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
# Software rendering gives the same picture on every computer.
FLAGS = [
    "--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--hide-scrollbars", "--no-first-run", "--disable-extensions", "--disable-background-networking", "--mute-audio",
    "--disable-component-update", "--force-device-scale-factor=1",
]
PATIENCE = 120.0
# Builds of Chromium for servers write this on the console where a page reads pixels, as the choice of the first view does. It is of the
# graphics driver, and no error of the page.
STALL = re.compile(r"\[\.WebGL-0x[0-9a-f]+\]GL Driver Message \(OpenGL, Performance, GL_CLOSE_PATH_NV, High\): "
                   r"GPU stall due to ReadPixels( \(this message will no longer repeat\))?")


def find() -> Optional[str]:
    """Returns the program if there is one; EXTRICATE_CHROMIUM names another."""
    return os.environ.get("EXTRICATE_CHROMIUM") or next((found for name in NAMES if (found := shutil.which(name))), None)


class Browser:
    """One page. `errors` has its errors, `requests` its requests to a network."""

    def __init__(self, program: str, width: int = 1400, height: int = 900) -> None:
        self.folder = tempfile.TemporaryDirectory(prefix="extricate-chromium-", ignore_cleanup_errors=True)
        (read_here, answers), (commands, write_here) = os.pipe(), os.pipe()
        # Chromium takes its pipes at the numbers 3 and 4, so keep these free.
        fds = [fcntl.fcntl(fd, fcntl.F_DUPFD, 10) for fd in (commands, answers)]
        os.close(commands)
        os.close(answers)
        command = [program, *FLAGS, f"--window-size={width},{height}", f"--user-data-dir={self.folder.name}", "about:blank"]
        script = 'exec "$@" 3<&"$IN" 4>&"$OUT"'
        environment = dict(os.environ, IN=str(fds[0]), OUT=str(fds[1]))
        self.process = subprocess.Popen(["bash", "-c", script, "chromium", *command], env=environment, pass_fds=fds,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for fd in fds:
            os.close(fd)
        self.reader, self.writer = read_here, write_here
        self.pending, self.number = b"", 0
        self.errors: list[str] = []
        self.requests: list[str] = []
        self.loaded = False
        self.session: Optional[str] = None
        targets = self.ask("Target.getTargets")["targetInfos"]
        page = next(target for target in targets if target["type"] == "page")
        self.session = self.ask("Target.attachToTarget", targetId=page["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.ask(f"{domain}.enable")
        self.size(width, height)

    def size(self, width: int, height: int, touch: bool = False) -> None:
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=touch)

    def ask(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Sends a command, and waits for its result."""
        self.number += 1
        message: dict[str, Any] = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.writer, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            found = self.next(until)
            if found.get("id") == self.number:
                if "error" in found:
                    raise RuntimeError(f"{method}: {found['error']['message']}")
                return found["result"]
        raise TimeoutError(method)

    def next(self, until: float) -> dict[str, Any]:
        """Returns the next message, and keeps events on the way."""
        while b"\0" not in self.pending:
            ready, _, _ = select.select([self.reader], [], [], max(0.0, until - time.monotonic()))
            piece = os.read(self.reader, 1 << 20) if ready else b""
            if not piece:
                raise TimeoutError("Chromium says nothing more")
            self.pending += piece
        text, self.pending = self.pending.split(b"\0", 1)
        message = json.loads(text)
        self.note(message)
        return message

    def note(self, message: dict[str, Any]) -> None:
        method, parameters = message.get("method"), message.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = parameters["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning", "assert"):
            self.errors.append(" ".join(str(arg.get("value", arg.get("description"))) for arg in parameters["args"]))
        elif method == "Log.entryAdded" and parameters["entry"]["level"] in ("error", "warning"):
            if not STALL.fullmatch(parameters["entry"]["text"]):
                self.errors.append(parameters["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])
        elif method == "Page.loadEventFired":
            self.loaded = True

    def open(self, address: str) -> None:
        """Opens a page, and waits until it is loaded."""
        self.errors, self.requests, self.loaded = [], [], False
        self.ask("Page.navigate", url=address)
        self.wait()

    def reload(self) -> None:
        """Opens the page again, and waits until it is loaded. What a page is asked before that is lost with the old one."""
        self.loaded = False
        self.ask("Page.reload")
        self.wait()

    def wait(self) -> None:
        until = time.monotonic() + PATIENCE
        while not self.loaded:
            self.next(until)

    def run(self, script: str) -> Any:
        """Returns the value of an expression in the page, after awaiting promises."""
        found = self.ask("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in found:
            raise RuntimeError(found["exceptionDetails"].get("exception", {}).get("description", "an exception"))
        return found["result"].get("value")

    def press(self, key: str) -> None:
        """Presses a key, as `KeyboardEvent.key` names it."""
        text: dict[str, Any] = {"text": key} if len(key) == 1 else {"windowsVirtualKeyCode": 9} if key == "Tab" else {}
        self.ask("Input.dispatchKeyEvent", type="keyDown", key=key, **text)
        self.ask("Input.dispatchKeyEvent", type="keyUp", key=key)

    def processor_seconds(self) -> float:
        """Returns the processor time of all processes of the browser so far, which other programs affect less than wall time."""
        parents, times = {}, {}
        for stat in Path("/proc").glob("[0-9]*/stat"):
            try:
                # The name of a program may contain blanks, and ends at the last bracket.
                fields = stat.read_text().rsplit(")", 1)[1].split()
            except OSError:
                continue
            parents[int(stat.parent.name)] = int(fields[1])
            times[int(stat.parent.name)] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        def is_own(pid: int) -> bool:
            return pid == self.process.pid or (pid in parents and parents[pid] > 1 and is_own(parents[pid]))
        return sum(seconds for pid, seconds in times.items() if is_own(pid))

    def picture(self, path: Path) -> None:
        path.write_bytes(base64.b64decode(self.ask("Page.captureScreenshot", format="png")["data"]))

    def close(self) -> None:
        try:
            self.session = None
            self.ask("Browser.close")
        except (TimeoutError, OSError, RuntimeError):
            self.process.kill()
        self.process.wait(timeout=30)
        os.close(self.reader)
        os.close(self.writer)
        self.folder.cleanup()

    def __enter__(self) -> "Browser":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
