#!/usr/bin/env python3
"""Pierce's continuous tests of sheets beside IPC Toolkit's, on the same steps of a recording.

    pip install ipctk numpy          # for this benchmark alone; nothing of it is installed or shipped
    pierce run layers --dt 0.008333 --seconds 0.0667 --record layers
    bench/ipc/compare_ipc.py layers --program build/release/bench/pierce_sheet_steps --out layers.csv

Both methods get the same float32 positions at both ends of a step, and take turns step by step, on
one thread each. Both have to answer two questions: which vertices and triangles, and which edges,
end the step closer than the thickness; and which of them meet during the step.

Pierce: World::set_motion() of all bodies, forget_sides() and detect(). Contacts come with places,
normals and times, sorted. If there is a solid, rays for vertices inside it are part of that.

IPC Toolkit:
    proximity  NormalCollisions.build() at the end of the step, dhat = thickness
    boxes      Candidates.build() over the motion
    meetings   is_step_collision_free() of these candidates. If nothing meets, as in all steps of a
               motion that was kept free of crossings, this asks each candidate over the whole step;
               if something meets, it stops there, and the column `free` is 0.
    step size  compute_collision_free_stepsize() of these candidates, for information
The table's IPC time is proximity + boxes + meetings, in the fastest of all ways that were tried on
some of the steps (broad phases, narrow phases, sets of collisions, one broad phase for both
questions or one each). The conversion of float32 to float64 and building the CollisionMesh are not
timed.

Times are wall-clock and processor time of the process. Where other programs share the cores, only
processor times can be compared.
"""
import argparse
import csv
import json
import pathlib
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

import ipctk
import numpy as np

RECORD = np.dtype([("kind", "i4"), ("found", "i4"), ("vertex", "i4", 6), ("distance", "f8"), ("time", "f8")])
NEAR, CROSSING = 4, 5  # pierce::Found
VERTEX, EDGES, TANGLED = 0, 1, 2  # kinds of records
BROAD_PHASES = ("LBVH", "HashGrid", "SpatialHash", "SweepAndPrune", "BruteForce")
SETS = {"ipc": ipctk.NormalCollisions.IPC, "ogc": ipctk.NormalCollisions.OGC}
NARROW_PHASES = {"additive": ipctk.AdditiveCCD, "tight-inclusion": ipctk.TightInclusionCCD}
GIVE_UP = 5  # a broad phase that is so many times slower than the fastest is not tried further
# IPC Toolkit keeps two edges as two edges where they are this close to parallel, whatever ends are closest.
NEARLY_PARALLEL = 1e-3  # squared sine


# ---- recordings (docs/recordings.md)


def read_obj(file):
    """Vertices and triangles of an OBJ file as Pierce writes it."""
    positions, triangles = [], []
    for line in open(file, encoding="ascii"):
        words = line.split()
        if words[:1] == ["v"]:
            positions.append([float(w) for w in words[1:4]])
        elif words[:1] == ["f"]:
            triangles.append([int(w.split("/")[0]) - 1 for w in words[1:4]])
    return np.array(positions, np.float32), np.array(triangles, np.int32)


class Recording:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        scene = json.loads((self.folder / "scene.json").read_text())
        meshes = {m["name"]: read_obj(self.folder / m["file"]) for m in scene["meshes"]}
        self.bodies, self.rest, self.triangles, self.body_of, first = scene["bodies"], [], [], [], 0
        self.values = []
        for k, body in enumerate(self.bodies):
            positions, triangles = meshes[body["mesh"]]
            if body["motion"] == "deforming":
                self.values.append(np.load(self.folder / body["positions"], mmap_mode="r"))
            else:
                poses = np.load(self.folder / body["poses"])
                if not np.array_equal(poses, np.broadcast_to(np.float32([0, 0, 0, 0, 0, 0, 1]), poses.shape)):
                    sys.exit("a body that does not deform must stay at the origin")
                self.values.append(positions[None])
            self.rest.append(positions)
            self.triangles.append(triangles + first)
            self.body_of.append(np.full(len(positions), k))
            first += len(positions)
        self.rest = np.asfortranarray(np.vstack(self.rest), dtype=np.float64)
        self.triangles = np.asfortranarray(np.vstack(self.triangles))
        self.body_of = np.concatenate(self.body_of)
        self.frames = max(len(v) for v in self.values)
        self.thickness = max(b.get("collision", {}).get("thickness", 0) for b in self.bodies)

    def frame(self, f):
        return np.asfortranarray(np.vstack([v[min(f, len(v) - 1)] for v in self.values]), dtype=np.float64)


def copy_of(folder, target, steps=None, only_sheets=False, shake=0.0, seed=1):
    """A recording of the sheets alone; or of some steps, two frames each, with sheets' ends shaken [length]."""
    folder, target = pathlib.Path(folder), pathlib.Path(target)
    random = np.random.default_rng(seed)
    scene = json.loads((folder / "scene.json").read_text())
    if only_sheets:
        scene["bodies"] = [b for b in scene["bodies"] if b.get("collision", {}).get("sheet")]
    for mesh in scene["meshes"]:
        shutil.copy(folder / mesh["file"], target)
    for body in scene["bodies"]:
        file = body.get("positions") or body.get("poses")
        values = np.load(folder / file, mmap_mode="r")
        if steps is not None:
            values = np.array(values[[min(f, len(values) - 1) for step in steps for f in step]])
            if body["motion"] == "deforming":
                values[1::2] += random.uniform(-shake, shake, values[1::2].shape).astype(np.float32)
        np.save(target / file, values)
    (target / "scene.json").write_text(json.dumps(scene))
    return target


# ---- Pierce


class Pierce:
    """The program pierce_sheet_steps, which waits for steps."""

    def __init__(self, program, folder):
        self.process = subprocess.Popen([program, str(folder), "1"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def ask(self, request):
        self.process.stdin.write((request + "\n").encode())
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            sys.exit("pierce_sheet_steps has ended")
        return json.loads(line)

    def step(self, begin, end):
        return self.ask(f"{begin} {end}")

    def contacts(self, begin, end):
        answer = self.ask(f"{begin} {end} contacts")
        data = self.process.stdout.read(answer["records"] * RECORD.itemsize)
        return np.frombuffer(data, RECORD)

    def edges(self, body):
        return np.array(self.ask(f"edges {body}"))


# ---- IPC Toolkit


def timed(times, name, work):
    processor, wall = time.process_time(), time.perf_counter()
    result = work()
    times[name] = (1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - processor))
    return result


class Ipc:
    def __init__(self, recording):
        ipctk.set_num_threads(1)
        self.dhat = recording.thickness
        edges = np.asfortranarray(ipctk.edges(recording.triangles))
        self.mesh = ipctk.CollisionMesh(recording.rest, edges, recording.triangles)
        self.broad, self.narrow, self.set, self.way = "LBVH", "additive", "ipc", "direct"

    def broad_phase(self):
        return getattr(ipctk, self.broad)()

    def collisions(self):
        result = ipctk.NormalCollisions()
        result.collision_set_type = SETS[self.set]
        return result

    def boxes(self, times, start, end, name="boxes", inflation=0.0):
        candidates, broad = ipctk.Candidates(), self.broad_phase()
        timed(times, name, lambda: candidates.build(self.mesh, start, end, inflation, broad))
        return candidates

    def meetings(self, times, candidates, start, end):
        narrow = NARROW_PHASES[self.narrow]()
        return timed(times, "meetings",
                     lambda: candidates.is_step_collision_free(self.mesh, start, end, 0.0, narrow))

    def proximity(self, times, end):
        collisions, broad = self.collisions(), self.broad_phase()
        if self.way == "direct":
            timed(times, "proximity", lambda: collisions.build(self.mesh, end, self.dhat, 0, broad))
        else:  # candidates first: their boxes reach half as far as those of the direct way
            def work():
                candidates = ipctk.Candidates()
                candidates.build(self.mesh, end, self.dhat / 2, broad)
                collisions.build(candidates, self.mesh, end, self.dhat, 0)
            timed(times, "proximity", work)
        return collisions

    def step(self, start, end):
        """Times of all parts, and what was found."""
        times = {}
        if self.way == "shared":  # one broad phase for both questions
            candidates = self.boxes(times, start, end, inflation=self.dhat / 2)
            collisions = self.collisions()
            timed(times, "proximity", lambda: collisions.build(candidates, self.mesh, end, self.dhat, 0))
        else:
            collisions = self.proximity(times, end)
            candidates = self.boxes(times, start, end)
        free = self.meetings(times, candidates, start, end)
        return times, collisions, candidates, free

    def step_size(self, times, candidates, start, end):
        narrow = NARROW_PHASES[self.narrow]()
        timed(times, "step_size",
              lambda: candidates.compute_collision_free_stepsize(self.mesh, start, end, 0.0, narrow))

    def choose(self, recording, steps, rounds):
        """Takes the fastest way, by processor time, and tells of all ways tried."""
        rows, best = [], {}
        ends = [(recording.frame(b), recording.frame(e)) for b, e in steps]

        def cost(what, work):
            total = min(sum(work(s, e) for s, e in ends) for _ in range(rounds)) / len(ends)
            rows.append((what, total))
            print(f"  {what:<60} {total:10.2f} ms", flush=True)
            return total

        fastest = None
        for name in BROAD_PHASES:
            if name == "BruteForce" and len(recording.rest) > 2000:
                continue
            self.broad = name

            def work(s, e):
                times = {}
                self.boxes(times, s, e)
                return times["boxes"][1]
            start, end = ends[0]
            first = work(start, end)
            if fastest is not None and first > GIVE_UP * fastest[0]:
                rows.append((f"boxes, {name}, once", first))
                print(f"  {f'boxes, {name}, once':<60} {first:10.2f} ms", flush=True)
                continue
            taken = cost(f"boxes, {name}", work)
            fastest = min(fastest or (taken, name), (taken, name))
        self.broad = fastest[1]

        for self.narrow in NARROW_PHASES:
            def work(s, e):
                times = {}
                self.meetings(times, self.boxes(times, s, e), s, e)
                return times["meetings"][1]
            best[self.narrow] = cost(f"meetings, {self.broad}, {self.narrow}", work)
        self.narrow = min(best, key=best.get)

        best = {}
        for self.set in SETS:
            for self.way in ("direct", "candidates", "shared"):
                def work(s, e):
                    return sum(t[1] for t in self.step(s, e)[0].values())
                best[self.set, self.way] = cost(
                    f"all, {self.broad}, {self.narrow}, set {self.set}, proximity {self.way}", work)
        self.set, self.way = min(best, key=best.get)
        return rows


# ---- what was found


def keys_of(kind, vertices):
    """One row per two features, the same for both methods."""
    v = np.asarray(vertices, np.int64)
    if kind == VERTEX:
        return np.hstack([v[:, :1], np.sort(v[:, 1:4], axis=1)])
    a, b = np.sort(v[:, :2], axis=1), np.sort(v[:, 2:4], axis=1)
    turn = (a[:, 0] > b[:, 0]) | ((a[:, 0] == b[:, 0]) & (a[:, 1] > b[:, 1]))
    return np.hstack([np.where(turn[:, None], b, a), np.where(turn[:, None], a, b)])


def as_set(keys):
    return set(map(tuple, keys.tolist()))


def features_of(collisions, mesh):
    """The vertices and triangles, and the edges, of IPC Toolkit's lists (collisions or candidates)."""
    faces, edges = np.asarray(mesh.faces), np.asarray(mesh.edges)
    fv = collisions.fv_collisions if hasattr(collisions, "fv_collisions") else collisions.fv_candidates
    ee = collisions.ee_collisions if hasattr(collisions, "ee_collisions") else collisions.ee_candidates
    fv = np.array([(c.vertex_id, c.face_id) for c in fv], np.int64).reshape(-1, 2)
    ee = np.array([(c.edge0_id, c.edge1_id) for c in ee], np.int64).reshape(-1, 2)
    return (keys_of(VERTEX, np.hstack([fv[:, :1], faces[fv[:, 1]]])),
            keys_of(EDGES, np.hstack([edges[ee[:, 0]], edges[ee[:, 1]]])))


def closest(kind, keys, at):
    """Distance of two features, whether their closest points are within both, and the squared sine of edges."""
    p = at[keys]  # n x 4 x 3

    def dot(a, b):
        return np.einsum("ij,ij->i", a, b)

    def to_segment(x, a, b):
        t = np.clip(dot(x - a, b - a) / np.maximum(dot(b - a, b - a), 1e-300), 0, 1)
        return np.linalg.norm(x - a - t[:, None] * (b - a), axis=1)

    if kind == VERTEX:
        x, a, b, c = p[:, 0], p[:, 1], p[:, 2], p[:, 3]
        n = np.cross(b - a, c - a)
        area = np.maximum(dot(n, n), 1e-300)
        w = np.stack([dot(n, np.cross(c - b, x - b)), dot(n, np.cross(a - c, x - c))]) / area
        inside = (w[0] >= 0) & (w[1] >= 0) & (w[0] + w[1] <= 1)
        border = np.minimum(np.minimum(to_segment(x, a, b), to_segment(x, b, c)), to_segment(x, c, a))
        return np.where(inside, np.abs(dot(n, x - a)) / np.sqrt(area), border), inside, np.ones(len(keys))
    a, b, c, d = p[:, 0], p[:, 1], p[:, 2], p[:, 3]
    u, v, w = b - a, d - c, a - c
    n = np.cross(u, v)
    size = np.maximum(dot(n, n), 1e-300)
    s, t = dot(n, np.cross(v, w)) / size, dot(n, np.cross(u, w)) / size
    inside = (s > 0) & (s < 1) & (t > 0) & (t < 1)
    ends = np.minimum(np.minimum(to_segment(a, c, d), to_segment(b, c, d)),
                      np.minimum(to_segment(c, a, b), to_segment(d, a, b)))
    sine = dot(n, n) / np.maximum(dot(u, u) * dot(v, v), 1e-300)
    return np.where(inside, np.minimum(ends, np.abs(dot(n, w)) / np.sqrt(size)), ends), inside, sine


def compare_near(recording, records, collisions, mesh, start, end):
    """Rows (what, count) of the contacts at the end of a step, in both lists or in one."""
    rows, d = [], recording.thickness
    ipc = features_of(collisions, mesh)
    rows.append(("ipc collisions of two vertices", len(collisions.vv_collisions)))
    rows.append(("ipc collisions of an edge and a vertex", len(collisions.ev_collisions)))
    for kind, name in ((VERTEX, "vertex and triangle"), (EDGES, "two edges")):
        mine = records[(records["kind"] == kind)]
        near = keys_of(kind, mine["vertex"][mine["found"] == NEAR])
        met = as_set(keys_of(kind, mine["vertex"][mine["found"] != NEAR]))
        pierce, other = as_set(near), as_set(ipc[kind])
        rows += [(f"{name}: Pierce near", len(pierce)), (f"{name}: Pierce crossing, remembered or tangled", len(met)),
                 (f"{name}: IPC", len(other)), (f"{name}: both", len(pierce & other))]

        def explain(who, keys):
            if not keys:
                return
            keys = np.array(sorted(keys))
            distance, inside, sine = closest(kind, keys, end)
            rest = closest(kind, keys, recording.rest)[0]
            own = recording.body_of[keys[:, 0]] == recording.body_of[keys[:, -1]]
            left = np.ones(len(keys), bool)

            def take(reason, which):
                nonlocal left
                count = int((left & which).sum())
                left &= ~which
                if count:
                    rows.append((f"{name}: {who} only, {reason}", count))
            take("meets during the step", np.array([tuple(k) in met for k in keys.tolist()]))
            take("at the thickness but for rounding", np.abs(distance - d) <= 1e-6 * d)
            take("further than half the distance at rest", own & (distance >= 0.5 * rest * (1 - 1e-9)))
            if kind == EDGES:
                take("nearly parallel edges, an end is closest", ~inside & (sine < NEARLY_PARALLEL))
                take("an end is closest", ~inside)
                take("nearly parallel edges", sine < NEARLY_PARALLEL)
            else:
                take("the triangle's border is closest", ~inside)
            take("further than the thickness", distance > d)
            take("other reasons", left.copy())
        explain("IPC", other - pierce)
        explain("Pierce", pierce - other)
    return rows


def meetings_of_ipc(keys, kind, start, end):
    """Which of the candidates meet, by IPC Toolkit's tight inclusion without a minimum distance."""
    test = (ipctk.tight_inclusion.point_triangle_ccd if kind == VERTEX else ipctk.tight_inclusion.edge_edge_ccd)
    return {tuple(k) for k in keys.tolist() if test(*start[k], *end[k])[0]}


def compare_meetings(folder, options, steps):
    """Steps with shaken ends, so that layers pass each other: Pierce, IPC Toolkit and the exact truth."""
    rows = []
    with tempfile.TemporaryDirectory() as temporary:
        thickness = Recording(folder).thickness
        copy = copy_of(folder, temporary, steps, shake=options.shake * thickness, seed=options.seed)
        subprocess.run([options.truth, str(copy), "--sheets"], check=True, stdout=subprocess.DEVNULL)
        truth = {f["frame"]: f for f in json.loads((copy / "sheets.json").read_text())["frames"]}
        recording, pierce = Recording(copy), Pierce(options.program, copy)
        ipc = Ipc(recording)
        first = np.concatenate([[0], np.cumsum([len(v[0]) for v in recording.values])])
        meshes = [pierce.edges(b) for b in range(len(recording.bodies))]
        owner = recording.body_of[recording.triangles[:, 0]]
        triangles = [recording.triangles[owner == b] for b in range(len(recording.bodies))]
        for k, (begin, finish) in enumerate(steps):
            start, end = recording.frame(2 * k), recording.frame(2 * k + 1)
            records = pierce.contacts(2 * k, 2 * k + 1)
            candidates = ipc.boxes({}, start, end)
            keys = features_of(candidates, ipc.mesh)
            for kind, name in ((VERTEX, "vertex and triangle"), (EDGES, "two edges")):
                true = []
                for m in truth[2 * k + 1]["meetings"]:
                    if m[0] != kind:
                        continue
                    true.append([first[m[1]] + m[2], *triangles[m[3]][m[4]]] if kind == VERTEX
                                else [*meshes[m[1]][m[2]], *meshes[m[3]][m[4]]])
                true = as_set(keys_of(kind, np.array(true, np.int64).reshape(-1, 4)))
                mine = as_set(keys_of(kind, records["vertex"][(records["kind"] == kind)
                                                              & (records["found"] == CROSSING)]))
                others = meetings_of_ipc(keys[kind], kind, start, end)
                rows.append((begin, finish, name, len(true), len(mine), len(true - mine), len(mine - true),
                             len(others), len(true - others), len(others - true)))
                print("  ", *rows[-1], flush=True)
    return rows


# ---- the benchmark


def machine():
    name = "unknown"
    for line in open("/proc/cpuinfo", encoding="ascii"):
        if line.startswith("model name"):
            name = line.split(":", 1)[1].strip()
            break
    return f"{name}, {platform.system()}"


def spread(values):
    """Median, 95th percentile, largest."""
    v = sorted(values)
    return statistics.median(v), v[min(len(v) - 1, int(0.95 * (len(v) - 1) + 0.5))], v[-1]


def write(file, header, columns, rows):
    with open(file, "w", newline="", encoding="utf-8") as out:
        out.write(f"# {header}\n")
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="a recording: docs/recordings.md")
    parser.add_argument("--program", default="build/release/bench/pierce_sheet_steps")
    parser.add_argument("--truth", help="the program pierce_truth, for --shake")
    parser.add_argument("--frames", default="", metavar="FIRST:LAST[:STRIDE]",
                        help="frames that the timed steps begin at; all if not given")
    parser.add_argument("--only-sheets", action="store_true", help="leave out bodies that are no sheets")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--choose", type=int, default=2, help="steps that the fastest way of IPC is chosen on")
    parser.add_argument("--compare", type=int, default=2, help="steps whose contacts are compared")
    parser.add_argument("--shake", type=float, default=0, metavar="X",
                        help="compare meetings, too, of steps whose ends are moved at random by up to X thicknesses")
    parser.add_argument("--name", help="of the scene; the folder's if not given")
    parser.add_argument("--commit", default="unknown", help="of Pierce")
    parser.add_argument("--seed", type=int, default=1, help="of the recording, and of --shake")
    parser.add_argument("--out", required=True, metavar="PREFIX", help="PREFIX_steps.csv and others are written")
    options = parser.parse_args()
    ipctk.set_logger_level(ipctk.LoggerLevel.error)

    with tempfile.TemporaryDirectory() as temporary:
        folder = copy_of(options.folder, temporary, only_sheets=True) if options.only_sheets else options.folder
        run(options, folder)


def run(options, folder):
    name = options.name or pathlib.Path(options.folder).name
    recording = Recording(folder)
    wanted = slice(*(int(w) if w else None for w in options.frames.split(":"))) if options.frames else slice(None)
    steps = [(f, f + 1) for f in range(recording.frames - 1)[wanted]]
    some = [steps[(2 * k + 1) * len(steps) // (2 * max(options.choose, 1))] for k in range(options.choose)]
    print(f"{name}: {len(recording.rest)} vertices, {len(recording.triangles)} triangles, {len(steps)} steps")

    ipc, pierce = Ipc(recording), Pierce(options.program, folder)
    chosen = ipc.choose(recording, some, 2)
    print(f"  fastest: {ipc.broad}, {ipc.narrow}, set {ipc.set}, proximity {ipc.way}")
    header = (f"{machine()}; Python {platform.python_version()}, ipctk {ipctk.__version__}, numpy {np.__version__}; "
              f"Pierce commit {options.commit}; scene {name}, seed {options.seed}; one thread each; "
              f"IPC: {ipc.broad}, {ipc.narrow}, set {ipc.set}, proximity {ipc.way}")
    write(f"{options.out}_ways.csv", header, ["way", "processor_ms"], [(w, f"{t:.3f}") for w, t in chosen])

    columns = ["round", "begin", "end", "pierce_wall_ms", "pierce_processor_ms", "pierce_sheets_stage_wall_ms",
               "pierce_contacts", "pierce_self_contacts", "pierce_triangle_pairs", "ipc_wall_ms", "ipc_processor_ms",
               "ipc_proximity_processor_ms", "ipc_boxes_processor_ms", "ipc_meetings_processor_ms",
               "ipc_step_size_processor_ms", "ipc_vv", "ipc_ev", "ipc_ee", "ipc_fv", "free"]
    rows = []
    for begin, end in some:  # neither of the two is timed cold
        pierce.step(begin, end)
    for k in range(options.rounds):
        for i, (begin, end) in enumerate(steps):
            start, finish = recording.frame(begin), recording.frame(end)
            if (k + i) % 2 == 0:
                mine = pierce.step(begin, end)
                times, collisions, candidates, free = ipc.step(start, finish)
            else:
                times, collisions, candidates, free = ipc.step(start, finish)
                mine = pierce.step(begin, end)
            wall, processor = (sum(t[c] for t in times.values()) for c in (0, 1))
            ipc.step_size(times, candidates, start, finish)
            rows.append([k, begin, end] + [f"{mine[c]:.3f}" for c in ("wall_ms", "processor_ms", "sheets_ms")]
                        + [mine["contacts"], mine["self_contacts"], mine["triangle_pairs"],
                           f"{wall:.3f}", f"{processor:.3f}"]
                        + [f"{times[c][1]:.3f}" for c in ("proximity", "boxes", "meetings", "step_size")]
                        + [len(collisions.vv_collisions), len(collisions.ev_collisions),
                           len(collisions.ee_collisions), len(collisions.fv_collisions), int(free)])
            del collisions, candidates
    write(f"{options.out}_steps.csv", header, columns, rows)

    def per_step(column):  # the median over the rounds, of every step
        at = columns.index(column)
        return [statistics.median(float(r[at]) for r in rows if r[1] == begin) for begin, _ in steps]

    summary = [("steps", len(steps), "", ""), ("rounds", options.rounds, "", "")]
    for column in columns[3:]:
        summary.append((column, *(f"{v:.3f}" for v in spread(per_step(column)))))
    for clock in ("wall", "processor"):
        ratios = [a / b for a, b in zip(per_step(f"ipc_{clock}_ms"), per_step(f"pierce_{clock}_ms"))]
        summary.append((f"ipc / pierce, {clock}", *(f"{v:.3f}" for v in (
            statistics.median(ratios), min(ratios), max(ratios)))))
    write(f"{options.out}_summary.csv",
          header + "; per step the median over the rounds; ratios: median, least, largest",
          ["what", "median", "p95", "max"], summary)
    for line in summary:
        print("  {:<34} {:>12} {:>12} {:>12}".format(*line))

    found = []
    for begin, end in some[:options.compare]:
        start, finish = recording.frame(begin), recording.frame(end)
        records = pierce.contacts(begin, end)
        for ipc.set in SETS:
            collisions = ipc.step(start, finish)[1]
            found += [(begin, end, ipc.set, *row)
                      for row in compare_near(recording, records, collisions, ipc.mesh, start, finish)]
    write(f"{options.out}_found.csv", header, ["begin", "end", "set", "what", "count"], found)
    for row in found:
        print("  ", *row)

    if options.shake > 0:
        met = compare_meetings(folder, options, some[:options.compare])
        write(f"{options.out}_meetings.csv",
              header + f"; ends shaken by {options.shake} thicknesses; IPC's meetings by tight inclusion without a "
              "minimum distance; truth by exact predicates",
              ["begin", "end", "features", "true", "pierce", "pierce_missed", "pierce_wrong", "ipc", "ipc_missed",
               "ipc_wrong"], met)


if __name__ == "__main__":
    main()
