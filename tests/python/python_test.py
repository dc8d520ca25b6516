#!/usr/bin/env python3
"""CTest `python`: what the package `orient` promises beyond its example.

    python_test.py PACKAGES   folder with the package `orient`
"""

import inspect
import json
import math
import pathlib
import re
import signal
import sys
import tempfile
import threading
import unittest

sys.path.insert(0, sys.argv.pop(1))
import numpy as np  # noqa: E402

import orient  # noqa: E402
from orient import _native  # noqa: E402

CAMERA = """
name = "digital"
kind = "digital"
principal_distance_mm = 100.0
principal_point_mm = [0.1, -0.05]
frame_mm = [60.0, 40.0]
image_px = [6000, 4000]

[distortion]
model = "brown"
k = [1e-8, 0.0, 0.0]
p = [0.0, 0.0]
"""


class Commands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        orient.run("simulate", out=cls.folder / "block", photos=1, camera_preset="digital",
                   pixel_size_um=240, gsd_m=3, relief_m=30, bare=True, earth="flat")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_bad_words_are_usage_errors_with_the_programs_message(self):
        with self.assertRaisesRegex(orient.UsageError, "overwite.*did you mean --overwrite"):
            orient.run("interior", "x.tif", overwite=True)

    def test_missing_files_are_input_errors(self):
        with self.assertRaisesRegex(orient.InputError, "nowhere.toml"):
            orient.run("block", self.folder / "nowhere.toml")

    def test_values_of_all_kinds_become_words(self):
        self.assertEqual(orient._option("--a", np.True_), ["--a"])
        self.assertEqual(orient._option("--a", False), [])
        self.assertEqual(orient._option("--a", (str(i) for i in range(2))), ["--a", "0", "1"])
        self.assertEqual(orient._option("--a", []), [])
        self.assertEqual(orient._option("--a", pathlib.Path("x y")), ["--a", "x y"])
        self.assertEqual(orient._option("--a", b"x y"), ["--a", "x y"])
        self.assertEqual(orient._option("--a", [b"x", pathlib.Path("y")]), ["--a", "x", "y"])
        with self.assertRaisesRegex(orient.InputError, "cannot read nowhere.toml"):
            orient.run("block", b"nowhere.toml")

    def test_a_command_that_serves_is_for_a_shell(self):
        with self.assertRaisesRegex(orient.UsageError, "shell"):
            orient.run("review", self.folder)

    def test_output_and_messages_are_returned(self):
        said = orient.run("--version")
        self.assertTrue(said.all_done)
        self.assertEqual(said.output, f"orient {orient.__version__}\n")

    def test_what_progress_raises_ends_the_command(self):
        class Enough(Exception):
            pass

        def stop(task, done, total):
            raise Enough(task)
        out = self.folder / "stopped"
        with self.assertRaises(Enough):
            orient.run("simulate", out=out, photos=2, camera_preset="digital", pixel_size_um=240,
                       gsd_m=3, bare=True, progress=stop)
        self.assertTrue(orient.run("--version").all_done, "the next command runs")

    def test_control_c_is_a_keyboard_interrupt(self):
        main = threading.main_thread().ident
        timer = threading.Timer(0.5, lambda: signal.pthread_kill(main, signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            orient.run("simulate", out=self.folder / "interrupted", photos=40, camera_preset="digital",
                       pixel_size_um=120, gsd_m=1.5, log=self.folder / "interrupted.log")
        timer.join()
        log = (self.folder / "interrupted.log").read_text(encoding="utf-8")
        self.assertIn("stopped", log)
        self.assertNotIn("internal error", log)

    def test_one_command_at_a_time(self):
        seen = []

        def another(*_):
            try:
                orient.run("--version")
            except RuntimeError as error:
                seen.append(str(error))
        orient.run("simulate", out=self.folder / "second", photos=1, camera_preset="digital",
                   pixel_size_um=240, gsd_m=3, bare=True, progress=another)
        self.assertTrue(seen and "another command" in seen[0], seen)


class Results(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.temporary.name)

    def tearDown(self):
        self.temporary.cleanup()

    def test_a_photo_without_a_pose_has_nan(self):
        result = {"photo": "4711", "status": "failed", "pose": None, "covariance": None,
                  "sigma0_px": None, "iterations": [], "patches": [], "messages": [],
                  "findings": [{"code": "no_approximation", "at_best": "failed"}]}
        (self.folder / "4711.exterior.json").write_text(json.dumps(result), encoding="utf-8")
        block = orient.Block(self.folder)
        self.assertEqual(block.statuses, ["failed"])
        self.assertIn("approximat", str(block["4711"].findings[0]))
        self.assertTrue(np.isnan(block.positions).all() and block.positions.shape == (1, 3))
        self.assertEqual(block.covariances.shape, (1, 6, 6))
        self.assertEqual([photo.photo for photo in block], ["4711"])
        self.assertTrue("4711" in block and "4712" not in block)
        self.assertEqual(orient.Block(str(self.folder).encode()).names, ["4711"])
        self.assertIsNone(block.crs)

    def test_an_empty_folder_is_no_block(self):
        with self.assertRaisesRegex(orient.InputError, "holds no"):
            orient.Block(self.folder)

    def test_damaged_results_are_named(self):
        (self.folder / "4711.exterior.json").write_text("{", encoding="utf-8")
        with self.assertRaisesRegex(orient.InputError, "4711.exterior.json"):
            orient.Block(self.folder)


class Geometry(unittest.TestCase):
    def setUp(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml", delete=False) as file:
            file.write(CAMERA)
            file.flush()
            self.camera = file.name
            self.addCleanup(pathlib.Path(file.name).unlink)
            self.pose = np.array([1000.0, 2000, 1500, 0.02, -0.03, 1.2])
            self.photo = orient.PhotoGeometry.of_pose(file.name, self.pose)

    def test_pixels_are_those_of_the_collinearity_equations(self):
        omega, phi, kappa = self.pose[3:]
        cos, sin = math.cos, math.sin
        about_x = np.array([[1, 0, 0], [0, cos(omega), -sin(omega)], [0, sin(omega), cos(omega)]])
        about_y = np.array([[cos(phi), 0, sin(phi)], [0, 1, 0], [-sin(phi), 0, cos(phi)]])
        about_z = np.array([[cos(kappa), -sin(kappa), 0], [sin(kappa), cos(kappa), 0], [0, 0, 1]])
        ground = np.array([[1050.0, 2080, 12], [900, 1900, -5]])
        d = (ground - self.pose[:3]) @ (about_x @ about_y @ about_z)
        reduced = -100 * d[:, :2] / d[:, 2:]
        r2 = (reduced ** 2).sum(axis=1, keepdims=True)
        # x = xp + reduced + its distortion; a pixel is 0.01 mm, the frame's centre (3000, 2000).
        photo = np.array([0.1, -0.05]) + reduced * (1 + 1e-8 * r2)
        expected = np.array([3000, 2000]) + photo * [100, -100]
        np.testing.assert_allclose(self.photo.pixels(ground), expected, atol=1e-3)

    def test_rays_lead_back_to_the_ground(self):
        ground = np.array([[1050.0, 2080, 12], [900, 1900, -5]])
        rays = self.photo.rays(self.photo.pixels(ground))
        way = ground - self.pose[:3]
        np.testing.assert_allclose(rays, way / np.linalg.norm(way, axis=1, keepdims=True), atol=1e-9)

    def test_what_is_not_shown_is_nan(self):
        self.assertTrue(np.isnan(self.photo.pixels([[90000.0, 0, 0], [1000, 2000, 9000]])).all())
        self.assertTrue(np.isnan(self.photo.rays([[1e6, 1e6], [-2, 10]])).all())
        self.assertFalse(np.isnan(self.photo.rays([[0, 0], [6000, 4000]])).any(), "its corners")

    def test_other_shapes_are_refused(self):
        with self.assertRaisesRegex(ValueError, r"\(n, 3\)"):
            self.photo.pixels(np.zeros((4, 2)))
        self.assertEqual(self.photo.pixels(np.zeros((0, 3))).shape, (0, 2))
        for shape in ((0, 6), (2, 6), (5,), (6, 1), (2, 3), ()):
            with self.assertRaisesRegex(ValueError, r"omega, phi, kappa") as caught:
                orient.PhotoGeometry.of_pose(self.camera, np.zeros(shape))
            self.assertIn(f"shape {shape};", str(caught.exception))

    def test_paths_may_be_of_pathlib(self):
        for camera in (pathlib.Path(self.camera), self.camera.encode()):
            photo = orient.PhotoGeometry.of_pose(camera, self.pose)
            np.testing.assert_array_equal(photo.pose, self.photo.pose)
        nowhere = pathlib.Path("no") / "where"
        for read in (lambda: orient.Surface(nowhere, "EPSG:32635"), lambda: orient.read_poses(nowhere),
                     lambda: orient.read_exterior(nowhere), lambda: orient.read_interior(nowhere),
                     lambda: orient.PhotoGeometry.of_result(nowhere, "4711", interior=nowhere)):
            with self.assertRaisesRegex(orient.InputError, "no/where"):
                read()

    def test_cameras_of_the_library_are_found_by_name(self):
        with self.assertRaisesRegex(orient.InputError, "wild_rc10.toml is a film camera"):
            orient.PhotoGeometry.of_pose("wild_rc10", self.pose)
        with self.assertRaisesRegex(orient.InputError, "nor in the library"):
            orient.PhotoGeometry.of_pose("wild_rc1000", self.pose)

    def test_calls_with_other_arguments_are_told_what_is_expected_and_print_no_array(self):
        many = [[i + 0.125, 1.0] for i in range(900)]
        for call, expected in ((lambda: self.photo.ground(many), r"ground\(pixels, surface\)"),
                               (lambda: self.photo.ground(many, "dem.tif"), "orient.Surface"),
                               (lambda: self.photo.pixels(many, many), r"\(n, 3\)"),
                               (lambda: self.photo.pixels(ground=[["a", "b", "c"]]), "numbers"),
                               (lambda: self.photo.rays(many, 1), r"\(n, 2\)"),
                               (lambda: self.photo.photo_mm(), r"\(n, 2\)"),
                               (lambda: orient.PhotoGeometry.of_pose(many, many), "six numbers")):
            with self.assertRaisesRegex(TypeError, expected) as caught:
                call()
            self.assertNotIn(".125", str(caught.exception))


class Stubs(unittest.TestCase):
    def test_the_stubs_name_all_that_is_there(self):
        stubs = pathlib.Path(_native.__file__).with_name("_native.pyi").read_text(encoding="utf-8")
        for name, member in inspect.getmembers(_native):
            if name.startswith("_"):
                continue
            self.assertRegex(stubs, rf"(?m)^((class|def) {name}\b|{name}:)", name)
            if not inspect.isclass(member) or issubclass(member, Exception):
                continue
            body = re.search(rf"^class {name}.*?(?=^\S)", stubs, re.MULTILINE | re.DOTALL).group(0)
            for attribute in vars(member):
                if not attribute.startswith("_"):
                    self.assertRegex(body, rf"def {attribute}\b", f"{name}.{attribute}")


if __name__ == "__main__":
    unittest.main()
