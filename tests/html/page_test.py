"""Pages of --html in Chromium.

  page_test.py --chromium PROGRAM --handhold PROGRAM --cloud table_scene.pcd [--screenshot F.png] [TEST...]

Ends with 77, which CTest shows as skipped, where there is no Chromium.
"""

import argparse
import array
import json
import math
import os
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

from browser import Browser, PageError

SKIPPED = 77
ARGUMENTS = None  # of the command line
# T_base_camera for the table scene before Baxter.
CAMERA_POSE = ["--camera-pose", "0.15", "0", "0.38", "-0.579", "0.690", "-0.333", "0.279", "--slot", "2"]


def handhold(*words):
    """Standard output of the program; a failure is an error of the test."""
    done = subprocess.run([ARGUMENTS.handhold, *words], capture_output=True, text=True, errors="replace",
                          timeout=300)
    if done.returncode:
        raise RuntimeError("handhold %s: %s" % (" ".join(words), done.stderr))
    return done.stdout


def write_wave(path, width, height):
    """A binary PCD: a waved floor, every point measured."""
    numbers = array.array("f")
    for row in range(height):
        for column in range(width):
            x, y = 0.002 * (column - width / 2), 0.002 * (row - height / 2)
            numbers.extend((x, y, 1.5 + 0.03 * math.sin(20 * x) * math.cos(20 * y)))
    with open(path, "wb") as file:
        file.write(("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH %d\nHEIGHT %d\n"
                    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS %d\nDATA binary\n" % (width, height, width * height)).encode())
        file.write(numbers.tobytes())


def png_pixels(png):
    """Width, height and rows (bytes) of a PNG of 8 bits without interlacing."""
    at, data = 8, b""
    while at < len(png):
        length, kind = struct.unpack(">I4s", png[at:at + 8])
        body = png[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, _, color = struct.unpack(">IIBB", body[:10])
        elif kind == b"IDAT":
            data += body
        at += 12 + length
    channels = {2: 3, 6: 4}[color]
    data, size, rows = zlib.decompress(data), channels * width, []
    before = bytearray(size)
    for y in range(height):
        method, row = data[y * (size + 1)], bytearray(data[y * (size + 1) + 1:(y + 1) * (size + 1)])
        for i in range(size):
            left, above = row[i - channels] if i >= channels else 0, before[i]
            corner = before[i - channels] if i >= channels else 0
            if method == 1:
                row[i] = (row[i] + left) & 255
            elif method == 2:
                row[i] = (row[i] + above) & 255
            elif method == 3:
                row[i] = (row[i] + (left + above) // 2) & 255
            elif method == 4:
                guess = left + above - corner
                distances = [abs(guess - left), abs(guess - above), abs(guess - corner)]
                row[i] = (row[i] + (left, above, corner)[distances.index(min(distances))]) & 255
        rows.append(bytes(row))
        before = row
    return width, height, [row if channels == 3 else bytes(b for i, b in enumerate(row) if i % 4 < 3) for row in rows]


class PageCase(unittest.TestCase):
    """A browser, a folder, and a page with what the program says of the same cloud."""

    webgl = True

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="handhold-pages-")
        cls.addClassCleanup(cls.folder.cleanup)
        cls.page = os.path.join(cls.folder.name, "page.html")
        handhold("localize", ARGUMENTS.cloud, "--min-confidence", "0.2", "--html", cls.page)
        cls.result = json.loads(handhold("localize", ARGUMENTS.cloud, "--min-confidence", "0.2", "--json", "-"))
        cls.browser = Browser(ARGUMENTS.chromium, webgl=cls.webgl)
        cls.addClassCleanup(cls.browser.close)

    def tearDown(self):
        self.browser.check()

    def text(self, selector):
        return self.browser.evaluate("document.querySelector(%s).textContent" % json.dumps(selector))

    def chosen(self):
        """Index of the handle whose numbers are shown, or None."""
        title = self.browser.evaluate(
            "document.getElementById('details').hidden ? '' : document.getElementById('details-title').textContent")
        return int(title.split()[1]) - 1 if title else None

    def centers(self):
        """Where the handles' centres are in the window (px), by index; of those with a label."""
        lines = self.browser.evaluate("""(() => {
          const box = document.getElementById("view").getBoundingClientRect();
          return [...document.querySelectorAll("#leaders line")].map(l => l.style.display === "none" ? null :
            [Number(l.getAttribute("x1")) + box.x, Number(l.getAttribute("y1")) + box.y]);
        })()""")
        return {i: tuple(place) for i, place in enumerate(lines) if place}


class LocalizePage(PageCase):
    def setUp(self):
        self.browser.screen(1280, 800)
        self.browser.open(self.page)

    def drawn(self):
        return self.browser.settle()

    def test_draws_what_was_found(self):
        handles = len(self.result["handles"])
        self.assertGreaterEqual(handles, 6)
        drawn = self.drawn()
        self.assertEqual(drawn, {"points": self.result["cloud"]["finite"], "labels": handles, "handles": handles,
                                 "approaches": handles, "grippers": 0, "affordances": 0, "samples": 0})
        self.assertEqual(self.browser.evaluate("document.title"), "table_scene.pcd – handhold")
        self.assertEqual(self.text("#name"), "table_scene.pcd")
        self.assertIn("5,000 samples", self.text("#summary"))

    def test_the_picture_has_cloud_and_handles_in_it(self):
        self.drawn()
        png = self.browser.screenshot()
        if ARGUMENTS.screenshot:
            with open(ARGUMENTS.screenshot, "wb") as file:
                file.write(png)
        _, height, rows = png_pixels(png)
        # Right of the panel: the background is one colour, and a good part of the picture is something else.
        rows = [row[3 * 345:] for row in rows]
        pixels = [row[i:i + 3] for row in rows[::3] for i in range(0, len(row), 9)]
        ground = max(set(pixels), key=pixels.count)
        self.assertEqual(ground, bytes((0x14, 0x17, 0x1c)))
        self.assertGreater(sum(p != ground for p in pixels), 0.25 * len(pixels))
        # Orange, the first handle's colour, seen through.
        orange = sum(p[0] > p[1] + 30 > p[2] + 60 for p in pixels)
        self.assertGreater(orange, 0.002 * len(pixels))

    def test_layers_go_and_come(self):
        for name, count, key in (("cloud", "points", "c"), ("handles", "handles", "h"), ("labels", "labels", "l"),
                                 ("approaches", "approaches", "v")):
            before = self.drawn()
            self.assertGreater(before[count], 0)
            self.browser.click_on("#layer-" + name)
            without = self.drawn()
            self.assertEqual(without, {**before, count: 0}, name)
            self.browser.key(key)
            self.assertEqual(self.drawn(), before, name)
        for name, key, number in (("affordances", "a", len(self.result["affordances"])),
                                  ("samples", "s", self.result["funnel"]["samples"])):
            self.browser.click_on("#layer-" + name)
            self.assertEqual(self.drawn()[name], number)
            self.browser.key(key)
            self.assertEqual(self.drawn()[name], 0)
            self.assertFalse(self.browser.evaluate("document.getElementById('layer-%s').checked" % name))

    def test_the_slider_leaves_out_what_is_less_sure(self):
        confidences = [handle["confidence"] for handle in self.result["handles"]]
        slider = "document.getElementById('threshold')"
        self.assertEqual(self.browser.evaluate(slider + ".value"), "0.2")
        self.browser.evaluate(slider + ".focus()")
        self.browser.key("ArrowRight")
        self.assertEqual(self.browser.evaluate(slider + ".value"), "0.21")
        self.browser.evaluate(slider + ".value = 0.9; " + slider + ".dispatchEvent(new Event('input'))")
        left = sum(c >= 0.9 for c in confidences)
        self.assertTrue(0 < left < len(confidences))
        drawn = self.drawn()
        self.assertEqual([drawn[name] for name in ("handles", "labels", "approaches")], [left] * 3)
        self.assertEqual(self.text("#handles-count"), "%d of %d" % (left, len(confidences)))
        self.assertEqual(self.browser.evaluate("document.querySelectorAll('#handles li:not([hidden])').length"), left)

    def test_a_click_on_a_handle_shows_its_numbers(self):
        self.drawn()
        self.assertIsNone(self.chosen())
        index, handle = 1, self.result["handles"][1]
        self.browser.click(*self.centers()[index])
        self.assertEqual(self.chosen(), index)
        numbers = self.text("#numbers")
        for text in ("%.3f" % handle["confidence"], "%.1f mm" % (1000 * handle["radius"]),
                     "%.1f mm" % (1000 * handle["length"]), ", ".join("%.1f" % (1000 * x) for x in handle["center"]),
                     ", ".join("%.3f" % x for x in handle["axis"])):
            self.assertIn(text.replace("-0.000", "0.000"), numbers.replace("-0.000", "0.000"))
        # Nothing is there.
        self.browser.click(1270, 780)
        self.assertIsNone(self.chosen())

    def test_list_labels_and_keys_choose_too(self):
        self.drawn()
        self.browser.click_on("#handles li:nth-child(3) button")
        self.assertEqual(self.chosen(), 2)
        self.browser.click_on("#labels button:nth-child(1)")
        self.assertEqual(self.chosen(), 0)
        self.browser.key("2")
        self.assertEqual(self.chosen(), 1)
        self.browser.key("n")
        self.assertEqual(self.chosen(), 2)
        self.browser.key("p")
        self.assertEqual(self.chosen(), 1)
        self.browser.key("Escape")
        self.assertIsNone(self.chosen())

    def test_the_camera_turns_moves_and_comes_back(self):
        self.drawn()
        start = self.centers()

        def changes(action):
            action()
            self.drawn()
            now = self.centers()
            self.assertNotEqual(now, start)
            self.browser.key("r")
            self.drawn()
            for i, place in self.centers().items():
                self.assertAlmostEqual(place[0], start[i][0], delta=0.2)
                self.assertAlmostEqual(place[1], start[i][1], delta=0.2)
            return now

        middle = (800, 600)
        changes(lambda: self.browser.drag(middle, (900, 560)))
        moved = changes(lambda: self.browser.drag(middle, (840, 620), button="right"))
        # In the plane of the target everything goes with the pointer.
        across = [moved[i][0] - start[i][0] for i in moved]
        self.assertAlmostEqual(sum(across) / len(across), 40, delta=12)

        def spread(places):
            return max(x for x, _ in places.values()) - min(x for x, _ in places.values())

        self.assertGreater(spread(changes(lambda: self.browser.wheel(*middle, -120))), 1.05 * spread(start))
        self.assertGreater(spread(changes(lambda: self.browser.key("+"))), 1.05 * spread(start))
        changes(lambda: self.browser.key("ArrowLeft"))
        changes(lambda: self.browser.key("t"))
        changes(lambda: self.browser.click(*middle, count=2))
        self.browser.key("2")
        looked = changes(lambda: self.browser.key("f"))
        self.assertAlmostEqual(looked[1][0], 340 + 470, delta=3)
        self.assertAlmostEqual(looked[1][1], 400, delta=3)

    def test_fingers(self):
        self.browser.screen(400, 800, ratio=2, mobile=True)
        self.browser.open(self.page)
        drawn = self.drawn()
        self.assertEqual(drawn["points"], self.result["cloud"]["finite"])
        self.assertEqual(self.browser.evaluate("document.getElementById('canvas').width"), 800)
        self.assertTrue(self.browser.evaluate("getComputedStyle(document.getElementById('panel')).display === 'none'"))
        start = self.centers()
        self.assertEqual(len(start), drawn["labels"])
        self.browser.fingers([(200, 400)], [(230, 400)], [(260, 410)])
        self.drawn()
        self.assertNotEqual(self.centers(), start)
        self.browser.click_on("#reset")
        self.drawn()
        self.browser.fingers([(150, 400), (250, 400)], [(130, 400), (270, 400)], [(100, 400), (300, 400)])
        self.drawn()
        a, b = (self.centers()[i][0] - start[i][0] for i in (1, 4) if i in self.centers()) if {1, 4} <= set(
            self.centers()) else (-1, 1)
        self.assertLess(a, b, "two fingers apart: nearer")
        self.browser.click_on("#reset")
        self.drawn()
        self.browser.fingers([self.centers()[1]])
        self.browser.click_on("#toggle-panel")
        self.assertEqual(self.chosen(), 1)

    def test_background_colours_sizes_and_help(self):
        self.drawn()
        self.browser.key("b")
        self.assertEqual(self.browser.evaluate("document.documentElement.dataset.theme"), "light")
        self.drawn()
        _, _, rows = png_pixels(self.browser.screenshot())
        self.assertEqual(rows[-100][-30:-27], bytes((0xf4, 0xf5, 0xf7)))
        names = self.browser.evaluate("[...document.querySelectorAll('#coloring option')].map(o => o.value)")
        self.assertEqual(names, ["plain", "depth", "height"], "the cloud has no colours")
        pictures = {self.browser.screenshot()}
        for _ in names[1:]:
            self.browser.key("m")
            self.drawn()
            pictures.add(self.browser.screenshot())
        self.browser.key("]")
        self.drawn()
        pictures.add(self.browser.screenshot())
        self.browser.key("e")
        self.drawn()
        pictures.add(self.browser.screenshot())
        self.assertEqual(len(pictures), len(names) + 2, "each looks different")
        self.browser.key("?")
        self.assertTrue(self.browser.evaluate("document.getElementById('help').open"))
        self.assertIn("double tap", self.text("#help"))
        self.browser.key("Escape")
        self.browser.wait("document.getElementById('help').open", lambda is_open: not is_open)

    def test_the_funnel_has_the_result_s_counts(self):
        rows = self.browser.evaluate("""[...document.querySelectorAll("#funnel details")].map(d =>
          [d.querySelector(".step").textContent, Number(d.querySelector(".number").textContent.replace(/,/g, "")),
           parseFloat(d.querySelector(".bar i").style.width)])""")
        funnel = self.result["funnel"]
        self.assertIn(["too little curved", funnel["curvature_low"]], [row[:2] for row in rows])
        self.assertIn(["in handles", funnel["in_handles"]], [row[:2] for row in rows])
        samples = rows[:[row[0] for row in rows].index("affordances") + 1]
        self.assertEqual(sum(row[1] for row in samples), funnel["samples"])
        for _, count, width in samples:
            self.assertAlmostEqual(width, 100 * count / funnel["samples"], delta=0.06)
        self.browser.click_on("#funnel details summary")
        self.assertIn("What would change it", self.browser.evaluate(
            "document.querySelector('#funnel details[open]').innerText"))

    def test_controls_have_names(self):
        unnamed = self.browser.evaluate("""[...document.querySelectorAll("button, input, select, canvas")].filter(e =>
          !(e.getAttribute("aria-label") || e.textContent.trim() || (e.labels && e.labels.length)))
          .map(e => e.outerHTML)""")
        self.assertEqual(unnamed, [])


class OtherPages(PageCase):
    def test_planned_grasps(self):
        try:
            plan = json.loads(handhold("plan", ARGUMENTS.cloud, *CAMERA_POSE, "--json", "-"))
        except RuntimeError as error:
            if "this build has no planner" in str(error):
                self.skipTest("built without a planner")
            raise
        page = os.path.join(self.folder.name, "plan.html")
        handhold("plan", ARGUMENTS.cloud, *CAMERA_POSE, "--html", page)
        self.browser.open(page)
        drawn = self.browser.settle()
        self.assertGreaterEqual(len(plan["grasps"]), 3)
        self.assertEqual(drawn["grippers"], len(plan["grasps"]))
        self.assertEqual(drawn["handles"], len(plan["handles"]))
        self.browser.key("g")
        self.assertEqual(self.browser.settle()["grippers"], 0)
        grasp, rejected = plan["grasps"][0], plan["rejected"][0]
        self.browser.click_on("#handles li:nth-child(%d) button" % (grasp["handle"] + 1))
        self.assertIn("%.1f mm" % (1000 * grasp["opening"]), self.text("#numbers"))
        self.browser.click_on("#handles li:nth-child(%d) button" % (rejected["handle"] + 1))
        self.assertIn("none: " + rejected["reason"], self.text("#numbers"))

    def test_a_large_cloud(self):
        cloud, page = (os.path.join(self.folder.name, name) for name in ("wave.pcd", "wave.html"))
        write_wave(cloud, 640, 470)
        handhold("localize", cloud, "--html", page)
        self.browser.open(page)
        self.assertEqual(self.browser.settle()["points"], 640 * 470)
        self.browser.drag((800, 400), (900, 420))
        self.assertEqual(self.browser.settle()["points"], 640 * 470)

    def test_nothing_found(self):
        cloud, page = (os.path.join(self.folder.name, name) for name in ("flat.pcd", "flat.html"))
        write_wave(cloud, 100, 100)
        handhold("localize", cloud, "--html", page)
        self.browser.open(page)
        drawn = self.browser.settle()
        self.assertEqual(drawn["points"], 10000)
        self.assertEqual(drawn["handles"], 0)
        self.assertIn("No handles", self.text("#notes"))

    def test_names_are_text(self):
        name = "<img src=x onerror=\"document.title='harmed'\">&lt;--<script>throw 1<b>\xff.pcd"
        path = os.path.join(self.folder.name, name).encode("latin-1")
        os.symlink(ARGUMENTS.cloud, path)
        page = os.path.join(self.folder.name, "named.html")
        handhold("localize", path, "--html", page)
        self.browser.open(page)
        self.browser.settle()
        shown = name.replace("\xff", "\ufffd")
        self.assertEqual(self.text("#name"), shown)
        self.assertEqual(self.browser.evaluate("document.title"), shown + " – handhold")
        self.assertEqual(self.browser.evaluate("document.images.length"), 0)

    def test_a_failing_script_is_noticed(self):
        with open(self.page, encoding="utf-8") as file:
            text = file.read()
        self.assertIn("\nnew App();", text)
        bad = os.path.join(self.folder.name, "bad.html")
        for wrong in ("\nnew App(); notThere();", "\nnew Ap();", "\nnew App(;"):
            with open(bad, "w", encoding="utf-8") as file:
                file.write(text.replace("\nnew App();", wrong))
            with self.assertRaises(PageError):
                self.browser.open(bad)
        self.browser.open(self.page)

    def test_a_network_is_noticed(self):
        with open(self.page, encoding="utf-8") as file:
            text = file.read()
        bad = os.path.join(self.folder.name, "bad.html")
        with open(bad, "w", encoding="utf-8") as file:
            file.write(text.replace("</main>", "<img alt='' src='http://127.0.0.1:9/x.png'></main>", 1))
        with self.assertRaises(PageError):
            self.browser.open(bad)
            self.browser.settle()
            self.browser.check()
        self.browser.open(self.page)


class WithoutWebGl(PageCase):
    webgl = False

    def test_says_so_and_has_the_numbers(self):
        self.browser.problems = []
        self.assertEqual(self.browser.open(self.page, states=("no-webgl",)), "no-webgl")
        self.assertIn("WebGL", self.browser.evaluate("document.getElementById('message').innerText"))
        self.assertEqual(self.browser.evaluate("document.querySelectorAll('#handles li').length"),
                         len(self.result["handles"]))
        self.browser.click_on("#handles li:nth-child(2) button")
        self.assertEqual(self.chosen(), 1)


class BrowserItself(unittest.TestCase):
    def test_leaves_nothing(self):
        with self.assertRaises(PageError):
            with Browser(ARGUMENTS.chromium) as browser:
                processes, folder = browser.processes(), browser._folder
                self.assertGreater(len(processes), 2)
                browser.evaluate("notThere()")
        for process in processes:
            self.assertFalse(os.path.exists("/proc/%d" % process))
        self.assertFalse(os.path.exists(folder))


def main():
    global ARGUMENTS
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--chromium", default="")
    parser.add_argument("--handhold", required=True)
    parser.add_argument("--cloud", required=True)
    parser.add_argument("--screenshot", help="keeps the picture of the first page")
    ARGUMENTS, rest = parser.parse_known_args()
    if not os.access(ARGUMENTS.chromium, os.X_OK):
        print("skipped: there is no Chromium; install chromium")
        sys.exit(SKIPPED)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)


if __name__ == "__main__":
    main()
