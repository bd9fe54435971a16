"""An X server without a screen, steered by xdotool: what a person would do with mouse and keys, and what they would see."""

import os
import subprocess

import numpy as np
import Xlib.display
import Xlib.X

from conftest import wait_until


class VirtualDisplay:
    """Xvfb with a screen of width x height pixels at a free display."""

    def __init__(self, width: int, height: int):
        self._size = (width, height)

    def __enter__(self) -> "VirtualDisplay":
        read, write = os.pipe()
        width, height = self._size
        self._server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{width}x{height}x24", "-nolisten", "tcp", "-noreset"],
            pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as number:
            self.name = f":{number.readline().strip()}"  # Xvfb writes it when it is ready
        assert self.name != ":", "Xvfb did not start"
        self._eye = Xlib.display.Display(self.name)
        return self

    def __exit__(self, *_):
        self._eye.close()
        self._server.terminate()
        self._server.wait(20)

    def xdotool(self, *words) -> str:
        done = subprocess.run(["xdotool", *map(str, words)], env=dict(os.environ, DISPLAY=self.name), capture_output=True, text=True, timeout=20, check=False)
        return done.stdout.strip()

    def wait_window(self, title: str) -> str:
        wait_until(lambda: self.xdotool("search", "--onlyvisible", "--name", title), what=f"window {title}")
        return self.xdotool("search", "--onlyvisible", "--name", title).splitlines()[-1]

    def move_window(self, title: str, x: int, y: int):
        """There is no window manager: the window is moved, and given the keys, by hand."""
        window = self.wait_window(title)
        self.xdotool("windowmove", "--sync", window, x, y)
        self.xdotool("windowfocus", "--sync", window)

    def click(self, x: int, y: int, button: int = 1):
        self.xdotool("mousemove", x, y, "sleep", 0.1, "click", button)

    def around(self, place):
        """What is shown there."""
        return self.picture()[place[1] - 8:place[1] + 8, place[0] - 40:place[0] + 40]

    def click_to_change(self, at, shown):
        """Clicks and waits until what it is to bring is around the place `shown`."""
        before = self.around(shown)
        self.click(*at)
        wait_until(lambda: not np.array_equal(self.around(shown), before), what=f"the picture around {shown} to change")

    def drag(self, start, end, button: int = 1, steps: int = 8):
        """Presses at start, goes to end in a few moves, as a hand does, and lets go there."""
        self.pull(start, end, button, steps)
        self.let_go(button)

    def pull(self, start, end, button: int = 1, steps: int = 8):
        """drag() without its end."""
        self.xdotool("mousemove", *start, "sleep", 0.15, "mousedown", button, "sleep", 0.15)
        for i in range(1, steps + 1):
            x, y = (round(a + (b - a) * i / steps) for a, b in zip(start, end))
            self.xdotool("mousemove", x, y, "sleep", 0.05)

    def let_go(self, button: int = 1):
        self.xdotool("sleep", 0.15, "mouseup", button)

    def key(self, *keys: str):
        self.xdotool("key", *keys)

    def hold(self, *keys: str):
        """Presses keys together for as long as a hand does: what is pressed and let go between two frames is lost to Dear ImGui 1.86."""
        pressed = [word for key in keys for word in ("keydown", key)]
        self.xdotool(*pressed, "sleep", 0.3, *[word for key in reversed(keys) for word in ("keyup", key)], "sleep", 0.1)

    def type(self, text: str):
        self.xdotool("type", "--delay", 40, text)

    def write(self, place, text: str):
        """Into a field, over what is there. Keys are lost when the window is held up for longer than hold() holds them: whoever writes looks for the effect."""
        self.click(*place)
        self.hold("ctrl", "a")
        self.type(text)
        self.hold("Return")

    def picture(self) -> np.ndarray:
        """The whole screen, HxWx3 BGR: what programs have drawn, each picture whole, without the mouse's arrow, which goes and comes with each."""
        width, height = self._size
        shown = self._eye.screen().root.get_image(0, 0, width, height, Xlib.X.ZPixmap, 0xFFFFFFFF)
        return np.frombuffer(shown.data, np.uint8).reshape(height, width, 4)[:, :, :3].copy()
