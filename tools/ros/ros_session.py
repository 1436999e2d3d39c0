"""A roscore of one's own and processes below it, for tests and measurements.

Nothing is shared with other sessions: the port is a free one, ROS_HOME and the logs are in a temporary folder. All
processes end with the session, and when this process is killed.
"""
import ctypes
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import xmlrpc.client

PR_SET_PDEATHSIG = 1
TIMEOUT_S = 120  # for what takes a second or so on an idle machine


def _end_with_parent():
    ctypes.CDLL("libc.so.6").prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


def _free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def wait_for(condition, what, timeout_s=TIMEOUT_S, explain=lambda: ""):
    """Waits until condition() is true, and returns what it returned."""
    end = time.monotonic() + timeout_s
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError(f"waited {timeout_s} s in vain: {what}\n{explain()}")


class Process:
    def __init__(self, name, popen, log):
        self.name, self.popen, self.log_path = name, popen, log

    @property
    def pid(self):
        return self.popen.pid

    def log(self):
        with open(self.log_path, errors="replace") as file:
            return file.read()

    def lives(self):
        return self.popen.poll() is None

    def end(self):
        """Ctrl-C; after a while, kill."""
        for sig, timeout_s in ((signal.SIGINT, 30), (signal.SIGTERM, 20), (signal.SIGKILL, 20)):
            if self.popen.poll() is not None:
                return
            try:
                os.killpg(self.popen.pid, sig)
            except ProcessLookupError:
                pass
            try:
                self.popen.wait(timeout_s)
            except subprocess.TimeoutExpired:
                continue


class Session:
    """build: the folder tools/ros of a build, which holds handhold_ros/ and python/."""

    def __init__(self, build):
        self.build = os.path.abspath(build)
        self.folder = tempfile.mkdtemp(prefix="handhold-ros-")
        self.processes = []
        self.env = dict(os.environ)
        for name in ("ROS_HOSTNAME", "ROS_NAMESPACE", "ROSCONSOLE_CONFIG_FILE"):
            self.env.pop(name, None)
        python_path = [os.path.join(self.build, "python"), self.env.get("PYTHONPATH", "")]
        self.env.update(
            ROS_HOME=self.folder,
            ROS_LOG_DIR=os.path.join(self.folder, "log"),
            ROS_IP="127.0.0.1",
            ROS_PACKAGE_PATH=self.build + ":/usr/share",
            PYTHONPATH=":".join(p for p in python_path if p),
            PATH="/usr/bin:" + self.env.get("PATH", ""),  # Debian's python3 for ROS's own tools
            ROSCONSOLE_STDOUT_LINE_BUFFERED="1",
            HANDHOLD_ROS_SESSION=self.folder,
        )
        try:
            self._start_master()
        except BaseException:
            self.close()
            raise

    def _start_master(self):
        for _ in range(5):
            port = _free_port()
            self.uri = f"http://127.0.0.1:{port}"
            self.env["ROS_MASTER_URI"] = self.uri
            core = self.start("roscore", ["roscore", "-p", str(port)])
            master = xmlrpc.client.ServerProxy(self.uri)

            def is_up():
                if not core.lives():
                    return True
                try:
                    return "/rosout" in str(master.getSystemState("/session"))
                except OSError:
                    return False

            wait_for(is_up, "roscore", explain=core.log)
            if core.lives():
                return
        raise AssertionError("no roscore on five ports: " + core.log())

    def start(self, name, command, env=None):
        """A process in a group of its own, with its output in a file."""
        log = os.path.join(self.folder, f"{name}-{len(self.processes)}.txt")
        with open(log, "w") as out:
            popen = subprocess.Popen(
                command,
                env={**self.env, **(env or {})},
                cwd=self.folder,
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                preexec_fn=_end_with_parent,
            )
        process = Process(name, popen, log)
        self.processes.append(process)
        return process

    def program(self, name):
        return os.path.join(self.build, "handhold_ros", name)

    def leftovers(self):
        """Processes of this session that still run: they carry its folder in their environment."""
        mark = f"HANDHOLD_ROS_SESSION={self.folder}".encode()
        found = []
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open(f"/proc/{pid}/environ", "rb") as file:
                    if mark in file.read().split(b"\0") and int(pid) != os.getpid():
                        found.append(int(pid))
            except OSError:
                pass
        return found

    def close(self):
        """Returns the processes that had to be killed."""
        while self.processes:
            self.processes.pop().end()
        left = self.leftovers()
        for pid in left:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        shutil.rmtree(self.folder, ignore_errors=True)
        return left

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
