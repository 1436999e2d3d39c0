"""Options by the TOML's names, with its messages."""

import os
import pathlib
import subprocess

import numpy as np
import pytest
from conftest import same

import handhold


def test_defaults_are_those_of_the_command_line():
    options = handhold.options()
    assert list(options)[:4] == ["method", "samples", "strategy", "seed"]
    assert options["method"] == "default" and options["samples"] == 5000
    assert options["radius"] is None and options["reach"] is None
    if "HANDHOLD_CLI" in os.environ:
        command = [os.environ["HANDHOLD_CLI"], "localize", "--print-options"]
        assert handhold.to_toml() == subprocess.run(command, check=True, capture_output=True, text=True).stdout


VALUES = {
    "method": "paper",
    "samples": 123,
    "strategy": "sum",
    "seed": 2**64 - 1,
    "proposal_sigma": 0.011,
    "workspace": [-1.0, 1.0, -2.0, 2.0, 0.0, 3.0],
    "radius": [0.03],
    "min_neighbours": 12,
    "axis": "pca",
    "index": "grid",
    "hand_aperture": 0.09,
    "hand_minimum": 0.01,
    "finger_thickness": 0.012,
    "finger_width": 0.021,
    "finger_depth": 0.05,
    "min_free": 0.25,
    "reach": 0.07,
    "shell_gap_area_mm2": 3.0,
    "shell_inner_area_mm2": 50.0,
    "align_angle": 0.3,
    "align_offset": 0.02,
    "align_radius": 0.006,
    "handle_gap": 0.016,
    "handle_min_affordances": 4,
    "handle_min_length": 0.03,
    "min_confidence": 0.4,
    "deadline_ms": 55.5,
    "backend": "auto",
    "threads": 2,
}


def test_every_option_is_set_and_told(tmp_path):
    assert list(VALUES) == list(handhold.options())
    defaults = handhold.options()
    for name, value in VALUES.items():
        assert value != defaults[name], "a value that would not show"
    assert handhold.options(**VALUES) == VALUES
    assert handhold.Localizer(**VALUES).options == VALUES
    path = tmp_path / "all.toml"
    path.write_text(handhold.to_toml(**VALUES))
    for config in path, str(path), os.fsencode(path):
        assert handhold.options(config=config) == VALUES
    assert handhold.options(**handhold.options()) == defaults


def test_unset_again(tmp_path):
    path = tmp_path / "some.toml"
    path.write_text('reach = 0.03\nradius = [0.01, 0.02]\nworkspace = [0, 1, 0, 1, 0, 1]\nsamples = 7\n')
    set_names = {"reach": 0.03, "radius": [0.01, 0.02], "workspace": [0, 1, 0, 1, 0, 1]}
    assert {name: handhold.options(config=path)[name] for name in set_names} == set_names
    for unset in None, "default":
        options = handhold.options(config=path, reach=unset, radius=unset, workspace=unset)
        assert options == handhold.options(samples=7)
    assert handhold.options(radius=[])["radius"] is None


def test_keywords_win_over_the_file_which_wins_over_the_hand(tmp_path):
    path = tmp_path / "hand.toml"
    path.write_text("hand_minimum = 0.02\nfinger_width = 0.03\n")
    baxter = handhold.options(hand="baxter")
    assert (baxter["hand_aperture"], baxter["hand_minimum"], baxter["finger_width"]) == (0.0767, 0.035, 0.016)
    for options in (
        handhold.options(hand="baxter", config=path, finger_width=0.04),
        handhold.options(finger_width=0.04, config=path, hand="baxter"),
    ):
        assert (options["hand_aperture"], options["hand_minimum"], options["finger_width"]) == (0.0767, 0.02, 0.04)


@pytest.mark.parametrize(
    "given, kept",
    [
        ({"samples": np.int64(7)}, 7),
        ({"seed": np.uint64(2**63)}, 2**63),
        ({"radius": 0.02}, [0.02]),
        ({"radius": 1}, [1.0]),
        ({"radius": np.float32(0.5)}, [0.5]),
        ({"radius": (0.01, 0.02)}, [0.01, 0.02]),
        ({"radius": np.array([0.01, 0.02])}, [0.01, 0.02]),
        ({"radius": np.array(0.02)}, [0.02]),
        ({"workspace": np.arange(6)}, [0, 1, 2, 3, 4, 5]),
        ({"reach": 1}, 1.0),
    ],
)
def test_numbers_of_numpy_and_python(given, kept):
    ((name, _),) = given.items()
    assert handhold.options(**given)[name] == kept


@pytest.mark.parametrize(
    "given, message",
    [
        ({"radiuss": 1}, "unknown option 'radiuss'; did you mean 'radius'?"),
        ({"aperture": 0.1}, "unknown option 'aperture'; did you mean 'hand_aperture'?"),
        ({"colour": 1}, "unknown option 'colour'; handhold.options() has them all"),
        ({"confg": "x"}, "unknown option 'confg'; did you mean 'config'?"),
        ({"Samples": 3}, "unknown option 'Samples'; did you mean 'samples'?"),
        ({"hand": "pr2"}, "unknown hand 'pr2'; must be 'baxter'"),
        ({"hand": 3}, "unknown hand 3; must be 'baxter'"),
        ({"samples": 0}, "samples = 0: must be between 1 and 10000000"),
        ({"samples": 5.0}, "samples = 5.0: must be a whole number"),
        ({"samples": True}, "samples = True: must be a whole number"),
        ({"samples": "5"}, "samples = '5': must be a whole number"),
        ({"samples": None}, "samples = None: must be a whole number"),
        ({"samples": 2**31}, "samples = 2147483648: must be a whole number of at most 2147483647"),
        ({"samples": -(2**40)}, "samples = -1099511627776: must be a whole number"),
        ({"seed": -1}, "seed = -1: must be a whole number of at least 0"),
        ({"seed": 2**64}, "seed = 18446744073709551616: must be a whole number of at most 18446744073709551615"),
        ({"reach": "far"}, "reach = 'far': must be a number"),
        ({"reach": [0.1]}, "reach = [0.1]: must be a number"),
        ({"reach": False}, "reach = False: must be a number"),
        ({"reach": 1j}, "reach = 1j: must be a number"),
        ({"hand_aperture": None}, "hand_aperture = None: must be a number"),
        ({"hand_aperture": float("nan")}, "hand_aperture = nan: must be greater than 0 and at most 1 m"),
        ({"hand_aperture": 10**400}, "hand_aperture = 1000"),
        ({"radius": -0.01}, "radius = -0.01: must be greater than 0 and at most 1 m"),
        ({"radius": [0.01, "x"]}, "radius = 'x': must be a number"),
        ({"radius": "0.01 0.02"}, "radius = '0.01 0.02': must be a number"),
        ({"radius": b"0.01"}, "radius = b'0.01': must be a number"),
        ({"radius": {0.01}}, "radius = {0.01}: must be a number"),
        ({"radius": [0.01] * 9}, "radius = 9 values: must be at most 8 radii"),
        ({"method": "paper", "radius": [0.01, 0.02]}, "radius = 2 values: must be one radius with method 'paper'"),
        ({"workspace": [0, 1]}, "workspace = [0, 1]: must be six numbers: [xmin, xmax, ymin, ymax, zmin, zmax]"),
        ({"workspace": 3}, "workspace = 3: must be six numbers: [xmin, xmax, ymin, ymax, zmin, zmax]"),
        ({"workspace": [1, 0, 0, 1, 0, 1]}, "workspace = 1 0: must be low < high along x"),
        ({"method": "papr"}, "method = 'papr': must be one of 'default', 'paper'"),
        ({"method": None}, "method = None: must be a string such as 'default'"),
        ({"backend": "gpu"}, "backend = 'gpu': must be one of 'cpu', 'cuda', 'auto'"),
        ({"strategy": 3}, "strategy = 3: must be a string such as 'max'"),
        ({"config": "/nothing/a.toml"}, "cannot read '/nothing/a.toml': no such file; give the name of a TOML file"),
        ({"config": b"/nothing/\xff"}, "cannot read '/nothing/\\xff': no such file; give the name of a TOML file"),
    ],
)
def test_what_is_no_option(given, message):
    cloud = np.zeros((3, 3), np.float32)

    def localize(**options):
        return handhold.localize(cloud, **options)

    for make in handhold.options, handhold.to_toml, handhold.Localizer, localize:
        with pytest.raises(ValueError) as error:
            make(**given)
        assert message in str(error.value)
        assert "\n" not in str(error.value) and len(str(error.value)) < 200


def test_localize_knows_its_own_keywords():
    cloud = np.zeros((3, 3), np.float32)
    with pytest.raises(ValueError, match="unknown option 'viewpiont'; did you mean 'viewpoint'?"):
        handhold.localize(cloud, viewpiont=None)
    with pytest.raises(ValueError, match="unknown option 'viewpoint'"):
        handhold.Localizer(viewpoint=None)
    with pytest.raises(TypeError):
        handhold.Localizer().localize(cloud, radius=0.01)
    with pytest.raises(TypeError):
        handhold.localize()


@pytest.mark.parametrize(
    "text, message",
    [
        ("radius = 0.01\nradiuss = 1\n", "F, line 2: unknown key 'radiuss'; did you mean 'radius'?"),
        ("samples = 0\n", "F, line 1: samples = 0: must be between 1 and 10000000"),
        ("a = = 3\n", "F, line 1: "),
        ('method = "x"\n', "F, line 1: method = 'x': must be one of 'default', 'paper'"),
    ],
)
def test_what_is_no_config(tmp_path, text, message):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(ValueError) as error:
        handhold.Localizer(config=path)
    assert message.replace("F", str(path)) in str(error.value)


def test_a_keyword_mends_the_file(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text("samples = 0\nseed = 9\n")
    assert handhold.options(config=path, samples=5)["seed"] == 9
    with pytest.raises(ValueError, match="^samples = -1: must be"):
        handhold.options(config=path, samples=-1)


def test_config_is_a_path():
    with pytest.raises(TypeError):
        handhold.options(config=3)
    with pytest.raises(ValueError, match="it is a folder"):
        handhold.options(config=pathlib.Path("/"))


def test_the_same_search_from_a_file(tmp_path, table):
    path = tmp_path / "hand.toml"
    path.write_text(handhold.to_toml(hand="baxter", samples=400))
    assert same(handhold.localize(table, config=path), handhold.localize(table, hand="baxter", samples=400))
