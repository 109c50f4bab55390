"""Recordings: written, read, replayed with the hashes of the C++ command, and validated."""

import gc
import json
import os
import subprocess
import weakref

import numpy as np
import pierce
import pytest
from conftest import box, torus


@pytest.fixture(scope="module")
def pile():
    return pierce.simulate("tori", count=6, seconds=0.7, threads=1)


def test_round_trip(pile, tmp_path):
    pile.write(tmp_path / "pile")
    again = pierce.Recording.read(tmp_path / "pile")
    assert again.frame_count == pile.frame_count and again.body_names == pile.body_names
    for body in range(len(pile.body_names)):
        np.testing.assert_array_equal(again.motion(body), pile.motion(body))
    with pytest.raises(pierce.InputError):
        pierce.Recording.read(str(tmp_path))


def test_replay_has_the_hashes_of_the_command(pile, tmp_path):
    command = os.environ.get("PIERCE_COMMAND")
    if not command:
        pytest.skip("PIERCE_COMMAND names no pierce command")
    pile.write(str(tmp_path / "pile"))
    out = tmp_path / "out.json"
    replay = [command, "replay", str(tmp_path / "pile"), "--threads", "1", "--json", str(out)]
    subprocess.run(replay, check=True, capture_output=True)
    frames = json.loads(out.read_text())["frames"]
    replay = pierce.Replay(pile, "embree", 1)
    hashes = [f"{replay.step(f).hash:016x}" for f in range(len(replay))]
    assert [frame["hash"] for frame in frames] == hashes and len(set(hashes)) > 5


def test_replays_agree(pile):
    one = pierce.Replay(pile, "embree", 2, coverage="complete")
    other = pierce.Replay(pile, "bvh", coverage="complete")
    for frame in range(0, len(one), 5):
        assert one.step(frame).hash == other.step(frame).hash
    with pytest.raises(IndexError, match="frame 1000"):
        one.step(1000)


def test_a_replay_keeps_the_filter_of_its_world(pile):
    replay = pierce.Replay(pile, "embree", 1)
    last = len(replay) - 1
    assert len(replay.step(last)) > 0
    assert replay.world is replay.world
    replay.world.set_pair_filter(lambda a, b: False)
    gc.collect()
    assert len(replay.step(last)) == 0
    replay.world.set_pair_filter(None)
    assert len(replay.step(last)) > 0


def test_a_filter_that_holds_a_replay_is_collected(pile):
    class Holder:
        def __init__(self):
            self.replay = pierce.Replay(pile, "reference")
            self.replay.world.set_pair_filter(self.wants)

        def wants(self, a, b):
            return True

    gone = weakref.ref(Holder())
    gc.collect()
    assert gone() is None


def test_validate(pile):
    found = pierce.validate(pile, ["embree", "bvh"], every=7)
    assert found.frames > 3 and found.differing_frames == 0
    assert [r.wrong_contacts for r in found.results] == [0, 0]


def test_a_recording_from_arrays(tmp_path):
    vertices, _ = torus()
    fall = np.zeros((10, 7), np.float32)
    fall[:, 2], fall[:, 6] = np.linspace(1.5, 0.6, 10), 1
    sway = vertices + np.linspace(0, 0.1, 10, dtype=np.float32)[:, None, None]
    ground = np.float32([[0, 0, -0.5, 0, 0, 0, 1]])
    made = pierce.Recording(
        1 / 60,
        [("box", box()), ("torus", torus())],
        [("ground", 0, "fixed", ground), ("box", 0, "rigid", fall), ("soft", 1, "deforming", sway)],
    )
    replay = pierce.Replay(made, "embree", 1)
    counts = [len(replay.step(frame)) for frame in range(10)]
    assert counts[0] < counts[-1]
    made.write(str(tmp_path / "made"))
    assert pierce.Recording.read(str(tmp_path / "made")).frame_count == 10
    with pytest.raises(ValueError, match=r"expected a motion of shape \(frames, 7\)"):
        pierce.Recording(0.1, [("box", box())], [("a", 0, "rigid", fall[0])])
    with pytest.raises(pierce.InputError, match="no frames"):
        pierce.Recording(0.1, [("box", box())], [("a", 0, "rigid", fall[:0])])
    for dt in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(pierce.InputError, match="dt must be positive"):
            pierce.Recording(dt, [("box", box())], [("a", 0, "rigid", fall)])
        with pytest.raises(pierce.InputError, match="dt must be positive"):
            pierce.simulate("tori", count=2, dt=dt)
    with pytest.raises(pierce.InputError, match="too many"):
        pierce.simulate("tori", count=2, seconds=np.inf)
    with pytest.raises(pierce.InputError, match="every Nth frame"):
        pierce.validate(made, ["embree", "bvh"], every=0)
    with pytest.raises(IndexError, match="no mesh 3"):
        pierce.Recording(0.1, [("box", box())], [("a", 3, "rigid", fall)])


def test_a_recording_of_nothing_is_refused():
    nothing = (np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32))
    motion = np.zeros((2, 0, 3), np.float32)
    with pytest.raises(pierce.InputError, match="mesh 'm' has no triangles"):
        pierce.Recording(0.1, [("m", nothing)], [("b", 0, "deforming", motion)])
    with pytest.raises(pierce.InputError, match="no bodies"):
        pierce.Recording(0.1, [], [])


def test_scenes():
    assert "tori" in pierce.scenes()
    with pytest.raises(pierce.InputError):
        pierce.simulate("nothing")
