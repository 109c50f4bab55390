"""Recorders, and the bar of loops."""

import io
import warnings

import numpy as np
import pierce
import pytest
from conftest import box


def test_a_recording_is_what_the_world_did(two_tori, tmp_path):
    world, rigid, soft, positions = two_tori
    recorder = pierce.Recorder(world, dt=0.5, names={soft: "soft"})
    hashes = []
    for k in range(5):
        world.set_pose(rigid, [0.125 * k, 0, 0, 0.5, 0.5, 0.5, 0.5])
        world.set_positions(soft, positions + np.float32(0.0625 * k))
        hashes.append(world.detect().hash)
        recorder.add()
    recording = recorder.recording()
    assert recording.frame_count == 5 and recording.dt == 0.5
    assert recording.body_names == ["torus", "soft"]
    recording.write(str(tmp_path / "motion"))
    again = pierce.Recording.read(str(tmp_path / "motion"))
    replay = pierce.Replay(again, threads=1, coverage="complete")
    assert [replay.step(k).hash for k in range(5)] == hashes and len(set(hashes)) == 5
    assert repr(recorder) == "Recorder(2 bodies, 5 frames)"


def test_meshes_of_one_name_insides_and_sheets_are_recorded(tmp_path):
    world = pierce.World("embree", 1, coverage="complete")
    vertices, triangles = box()
    large, small = world.add_mesh((vertices, triangles)), world.add_mesh((vertices / 2, triangles))
    hollow = world.add_mesh((vertices, triangles), "mesh 2", inside="none")
    world.add_rigid_body(large)
    world.add_rigid_body(small, [0.625, 0.125, 0.25, 0, 0, 0, 1])
    world.add_rigid_body(hollow, [-0.75, 0.125, 0.25, 0, 0, 0, 1])
    sheet = world.add_deforming_body(large, vertices + np.float32([0, 0, 0.875]))
    world.set_collision(sheet, pierce.Collision(sheet=True, thickness=0.3))
    near = world.add_deforming_body(small, vertices / 2 + np.float32([0.125, 0, -0.8125]))
    world.set_collision(near, pierce.Collision(margin=0.1))
    recorder = pierce.Recorder(world)
    hashes = []
    for _ in range(2):
        contacts = world.detect()
        hashes.append(contacts.hash)
        recorder.add()
    assert contacts.of_sheet.any() and (contacts.found == int(pierce.Found.near)).any()
    recorder.recording().write(str(tmp_path / "motion"))
    for recording in (recorder.recording(), pierce.Recording.read(str(tmp_path / "motion"))):
        replay = pierce.Replay(recording, "embree", 1, coverage="complete")
        assert [replay.step(frame).hash for frame in range(2)] == hashes


def test_nothing_is_no_recording(two_tori):
    recorder = pierce.Recorder(two_tori[0])
    with pytest.raises(ValueError, match="nothing was recorded"):
        recorder.recording()


def test_a_body_with_another_mesh_is_refused(two_tori):
    world, rigid, _, _ = two_tori
    recorder = pierce.Recorder(world)
    world.set_mesh(rigid, world.add_mesh(box()))
    with pytest.raises(ValueError, match="another mesh"):
        recorder.add()


def test_filters_and_excluded_pairs_are_recorded(tmp_path):
    world = pierce.World("embree", 1)
    mesh = world.add_mesh(box())
    bodies = [world.add_rigid_body(mesh, [0.25 * k, 0.125 * k, 0, 0, 0, 0, 1]) for k in range(6)]
    world.set_filter(bodies[1], pierce.Filter(groups=2, meets=5))
    world.set_filter(bodies[2], pierce.Filter(chain=7))
    world.set_filter(bodies[3], pierce.Filter(chain=7))
    world.set_filter(bodies[4], pierce.Filter(world=3))
    world.set_filter(bodies[5], pierce.Filter(world=4))
    world.exclude(bodies[2], bodies[0])
    assert world.excluded_pairs == [(bodies[0], bodies[2])]
    recorder = pierce.Recorder(world)
    expected = world.detect()
    recorder.add()
    recording = recorder.recording()
    recording.write(str(tmp_path / "motion"))
    for again in (recording, pierce.Recording.read(str(tmp_path / "motion"))):
        assert again.excluded == [(0, 2)]
        assert [again.filter(k) for k in range(6)] == [world.filter_of(b) for b in bodies]
        assert pierce.Replay(again, "embree", 1).step(0).hash == expected.hash
    world.include(bodies[0], bodies[2])
    assert world.excluded_pairs == [] and world.detect().hash != expected.hash


def test_bodies_that_do_not_exist_are_no_excluded_pair():
    mesh, pose = ("box", box()), np.float32([[0, 0, 0, 0, 0, 0, 1]])
    bodies = [("box", 0, pierce.Motion.rigid, pose)] * 2
    for pair in ((0, 2), (1, 1)):
        with pytest.raises(pierce.InputError, match="are no pair"):
            pierce.Recording(0.1, [mesh], bodies, [pair])


def test_only_static_bodies_may_have_one_frame():
    mesh = ("box", box())
    poses = np.tile(np.float32([0, 0, 0, 0, 0, 0, 1]), (3, 1))
    for motion in (pierce.Motion.fixed, pierce.Motion.rigid):
        bodies = [
            ("moves", 0, pierce.Motion.rigid, poses),
            ("stays", 0, motion, poses[:1]),
        ]
        if motion == pierce.Motion.fixed:
            assert pierce.Recording(0.1, [mesh], bodies).frame_count == 3
        else:
            with pytest.raises(ValueError, match="stays: expected 3 frames, got 1"):
                pierce.Recording(0.1, [mesh], bodies)


def test_bodies_that_came_later_are_not_recorded(two_tori):
    world, rigid, soft, _ = two_tori
    recorder = pierce.Recorder(world)
    recorder.add()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        recorder.recording()
    later = world.add_rigid_body(world.mesh_of(rigid))
    world.exclude(later, soft)
    with pytest.warns(UserWarning, match="1 bodies were added later"):
        recording = recorder.recording()
    assert len(recording.body_names) == 2 and recording.excluded == []


class Terminal(io.StringIO):
    def isatty(self):
        return True


def stops():
    yield from range(3)
    raise OSError("no more")


def test_track_shows_a_bar_on_terminals_only(monkeypatch):
    from pierce import progress

    monkeypatch.setattr(progress, "_REDRAW", 0)
    terminal, file = Terminal(), io.StringIO()
    assert list(pierce.track(range(4), "steps", out=terminal)) == [0, 1, 2, 3]
    assert "steps [" in terminal.getvalue() and "3/4" in terminal.getvalue()
    assert terminal.getvalue().endswith("\r\033[K")
    assert list(pierce.track((k for k in range(3)), out=terminal)) == [0, 1, 2]
    assert list(pierce.track(range(4), out=file)) == [0, 1, 2, 3] and file.getvalue() == ""
    for _ in pierce.track(range(4), out=(left := Terminal())):
        if left.getvalue():
            break
    assert left.getvalue().endswith("\r\033[K")
    with pytest.raises(OSError, match="no more"):
        list(pierce.track(stops(), out=(failed := Terminal())))
    assert "[" in failed.getvalue() and failed.getvalue().endswith("\r\033[K")
    monkeypatch.setattr("sys.stderr", None)
    assert list(pierce.track(range(4))) == [0, 1, 2, 3]
