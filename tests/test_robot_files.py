"""What `hdrm-fmu machine export` writes, MJCF and URDF, compared with Hdrm.fmu and with a planar trigonometry of its own.

Loops: MuJoCo has the tree's mass matrix M and bias c and the loops' Jacobian J, of which the test makes the equations in the six joint
angles. With q' = G zeta' and J G = 0, and J q'' = -J' q', q'' = G zeta'' + a: mass matrix G^T M G, bias G^T (M a + c).
"""

import json
import xml.etree.ElementTree as ET
from cmath import exp, phase
from math import copysign, cos, sin, sqrt

import mujoco
import numpy as np
import pinocchio
import pytest

from fmpy_master import ROOT
from native import call

JOINTS = [f"zeta_{i}" for i in range(1, 7)]
#: World axes of the files, z up, from those of Hdrm, y up.
UP = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
MACHINES = ["reference", "hiab_xs031", "scaled"]
RELATIVE = 1e-8


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """By machine: the machine file as Hdrm.fmu takes it, its whole content, MJCF, URDF."""
    folder, made = tmp_path_factory.mktemp("robots"), {}
    done = call("hdrm-fmu", "machine", "scale", "--booms", "1.3", "--output", folder / "scaled.json")
    assert done.returncode == 0, done.stderr
    for name in MACHINES:
        machine = folder / "scaled.json" if name == "scaled" else name
        own = {kind: folder / f"{name}.{kind}" for kind in ("mjcf", "urdf")}
        for kind, path in own.items():
            done = call("hdrm-fmu", "machine", "export", machine, f"--{kind}", path)
            assert done.returncode == 0 and done.stdout == "", done.stderr
        made[name] = str(machine), whole(folder, name), own["mjcf"], own["urdf"]
    return made


def whole(folder, name):
    """All fields of a machine: a file that says what differs, on top of the reference."""
    merged = lambda base, own: {**base, **{k: merged(base.get(k, {}), v) if isinstance(v, dict) else v for k, v in own.items()}}
    read = lambda path: json.loads(path.read_text())
    parameters = ROOT / "parameters"
    file = parameters / "hiab_xs031.json" if name == "hiab_xs031" else folder / "scaled.json"
    reference = read(parameters / "reference_machine.json")
    return reference if name == "reference" else merged(reference, read(file))


class Ours:
    """Hdrm.fmu with one machine, at any state."""

    def __init__(self, hdrm, file):
        self.instance, self.file = hdrm.instance(), file

    def at(self, zeta, rates=(0.0,) * 6, **inputs):
        self.instance.call("fmi2Reset")
        values = {f"zeta_start[{i + 1}]": v for i, v in enumerate(zeta)} | {f"zeta_dot_start[{i + 1}]": v for i, v in enumerate(rates)}
        self.instance.start(0.0, {"machine_file": self.file} | values | inputs)
        return self

    def get(self, name, n):
        return np.array(self.instance.get(*[f"{name}[{i + 1}]" for i in range(n)]))

    def equations(self, zeta, rates):
        """Mass matrix by the energy of pairs of rates, bias by the acceleration without forces, tip's Jacobian and gears of the rods."""
        unit = np.eye(6)
        energy = lambda rates: self.at(zeta, rates).instance.get("energy.kinetic")
        alone = [energy(e) for e in unit]
        M = np.diag([2 * e for e in alone])
        J, gears = np.zeros((6, 6)), np.zeros(3)
        for i in range(6):
            self.at(zeta, unit[i])
            J[:, i] = self.get("tip.velocity", 6)
            if i < 3:
                gears[i] = self.get("x_dot", 3)[i]
            for j in range(i):
                M[i, j] = M[j, i] = energy(unit[i] + unit[j]) - alone[i] - alone[j]
        friction = self.get("joint_viscous", 6) * rates
        free = self.at(zeta, rates).get("zeta_ddot", 6)
        return M, -M @ free - friction, J, gears


def poses(machine, zeta):
    """World poses of all bodies, 4x4, y up: planar trigonometry from the machine's file, in complex numbers. And the strokes."""
    g = machine["geometry"]
    point = lambda p: complex(p[0], p[1])
    boom, tilt = exp(1j * zeta[1]), exp(1j * (zeta[1] + zeta[2]))
    O = point(g["r_T1_O"])
    foot, pin = O + g["L2_2"] * complex(sin(g["beta1"]), -cos(g["beta1"])), O + g["L1_2"] * exp(1j * (zeta[1] - g["beta2"]))
    B = O + boom * point(g["r_O_B"])
    A, E, C = B + boom * point(g["A_in_boom"]), B + boom * point(g["E_in_boom"]), B + tilt * point(g["C_in_tilt"])
    # The pin D at d4 from A and d5 from C, on the side of the line AC away from B.
    side, u = abs(C - A), (C - A) / abs(C - A)
    along = (side**2 + g["d4"] ** 2 - g["d5"] ** 2) / (2 * side)
    D = A + u * complex(along, -copysign(sqrt(g["d4"] ** 2 - along**2), ((B - A) / u).imag))
    lift, push = pin - foot, D - E
    planar = {
        "A2": (O, zeta[1] - g["beta2"]),
        "C2": (foot, phase(lift)),
        "D2": (pin - g["lc_2"] * lift / abs(lift), phase(lift)),
        "A3": (B, zeta[1] + zeta[2]),
        "C3": (E, phase(push)),
        "D3": (D - g["lc_3"] * push / abs(push), phase(push)),
        "RK": (A, phase(D - A)),
        "CP": (C, phase(D - C)),
    }
    found = {"T1": pose([0, 0, 0], "y", zeta[0])}
    for name, (p, angle) in planar.items():
        found[name] = found["T1"] @ pose([p.real, p.imag, 0], "z", angle)
    assert g["r_T1_O"][2] == g["r_O_B"][2] == 0, "the joints of the booms do not lie in one plane"
    found["A4"] = found["A3"] @ pose(np.add(g["r_B_B4"], g["r_B4_A4"]), "x", zeta[3])
    found["C4"] = found["A4"] @ pose(g["r_A4_C4"], "z", zeta[4])
    found["D4"] = found["C4"] @ pose(g["r_C4_D4"], "x", zeta[5])
    found["PL"] = found["D4"]
    x = [g["x1_mid"] + g["r_B"] * zeta[0], abs(lift) - g["x0_2"], abs(push) - g["x0_3"]]
    return found, np.array(x)


def pose(r, axis, angle):
    c, s, T = cos(angle), sin(angle), np.eye(4)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    T[i, i] = T[j, j] = c
    T[j, i], T[i, j], T[:3, 3] = s, -s, r
    return T


def drawn(machine, ours, count=4):
    """Joint angles and rates by chance, with strokes off their ends."""
    limits, rng, made = machine["limits"], np.random.default_rng(7), []
    low, high = np.radians(limits["zeta_min_deg"]), np.radians(limits["zeta_max_deg"])
    strokes = np.array([limits[f"stroke_{i}"] for i in (1, 2, 3)])
    while len(made) < count:
        zeta, rates = rng.uniform(low, high), rng.uniform(-0.5, 0.5, 6)
        x = ours.at(zeta).get("x", 3)
        if all(strokes[:, 0] + 0.01 < x) and all(x < strokes[:, 1] - 0.01):
            made.append((zeta, rates))
    return made


def joint_values(machine, zeta):
    """Every joint of the files by name, from the bodies' poses."""
    found, x = poses(machine, zeta)
    angle = lambda parent, child: phase(complex(*(np.linalg.inv(found[parent]) @ found[child])[:2, 0]))
    passive = {"cylinder_2": ("T1", "C2"), "cylinder_3": ("A2", "C3"), "rocker": ("A2", "RK"), "coupler": ("A3", "CP")}
    return dict(zip(JOINTS, zeta)) | {"rod_2": x[1], "rod_3": x[2]} | {name: angle(*bodies) for name, bodies in passive.items()}


class Theirs:
    """The MJCF file in MuJoCo."""

    def __init__(self, path):
        self.m = mujoco.MjModel.from_xml_path(str(path))
        self.d = mujoco.MjData(self.m)
        self.zeta_dofs = self.dofs(JOINTS)

    def dofs(self, names):
        return [self.m.joint(name).dofadr[0] for name in names]

    def place(self, values):
        for name, value in values.items():
            self.d.joint(name).qpos = value
        mujoco.mj_kinematics(self.m, self.d)
        mujoco.mj_comPos(self.m, self.d)

    def loops(self, rates=None):
        """Errors of the pins, their Jacobian, and with rates its rate too."""
        m, d, errors, rows, turning = self.m, self.d, [], [], []
        for k in range(m.neq):
            assert m.eq_type[k] == mujoco.mjtEq.mjEQ_CONNECT
            ends = [(m.eq_obj1id[k], m.eq_data[k, :3]), (m.eq_obj2id[k], m.eq_data[k, 3:6])]
            points = [d.xpos[body] + d.xmat[body].reshape(3, 3) @ at for body, at in ends]
            jacobians, changes = np.zeros((2, 3, m.nv)), np.zeros((2, 3, m.nv))
            for end, (body, _) in enumerate(ends):
                mujoco.mj_jac(m, d, jacobians[end], None, points[end], body)
                if rates is not None:
                    mujoco.mj_jacDot(m, d, changes[end], None, points[end], body)
            errors.append(points[0] - points[1])
            rows.append(jacobians[0] - jacobians[1])
            turning.append(changes[0] - changes[1])
        return np.concatenate(errors), np.concatenate(rows), np.concatenate(turning)

    def move(self, zeta_rates):
        """Rates of all joints by those of the angles: G, and the part `a` of the accelerations that rates bring."""
        m, d, independent = self.m, self.d, self.zeta_dofs
        passive = [i for i in range(m.nv) if i not in independent]
        _, J, _ = self.loops()
        G = np.zeros((m.nv, 6))
        G[independent] = np.eye(6)
        G[passive] = np.linalg.lstsq(J[:, passive], -J[:, independent], rcond=1e-10)[0]
        d.qvel[:] = G @ zeta_rates
        mujoco.mj_forward(m, d)
        _, J, change = self.loops(d.qvel)
        a = np.zeros(m.nv)
        a[passive] = np.linalg.lstsq(J[:, passive], -change @ d.qvel, rcond=1e-10)[0]
        return G, a


def relative(found, expected):
    return np.abs(np.subtract(found, expected)).max() / np.abs(expected).max()


@pytest.mark.parametrize("name", MACHINES)
def test_mjcf_is_the_machine(files, hdrm, name):
    """Masses, poses, loops, mass matrix, bias, the tip and its Jacobian, gears of the rods: at random poses to 1e-8 of the largest entry.
    MuJoCo's own accelerations, with soft pins, to 2e-3."""
    file, machine, path, _ = files[name]
    ours, theirs = Ours(hdrm, file), Theirs(path)
    m, d = theirs.m, theirs.d
    assert {m.body(i).name for i in range(1, m.nbody)} == set(machine["bodies"]), "only the paper's bodies"
    for body, is_like in machine["bodies"].items():
        assert m.body(body).mass[0] == is_like["mass"]
    worst = dict.fromkeys(("pose", "loop", "M", "bias", "tip", "jacobian", "gears", "soft"), 0.0)

    def seen(what, value):
        worst[what] = max(worst[what], value)

    for zeta, rates in drawn(machine, ours):
        at, x = poses(machine, zeta)
        theirs.place(joint_values(machine, zeta))
        for body, T in at.items():
            seen("pose", np.abs(d.body(body).xpos - UP @ T[:3, 3]).max())
            seen("pose", np.abs(d.body(body).xmat.reshape(3, 3) - UP @ T[:3, :3]).max())
        seen("loop", np.abs(theirs.loops()[0]).max())
        M, bias, J, gears = ours.equations(zeta, rates)
        G, a = theirs.move(rates)
        full = np.zeros((m.nv, m.nv))
        mujoco.mj_fullM(m, d, full)
        seen("M", relative(G.T @ full @ G, M))
        seen("bias", relative(G.T @ (full @ a + d.qfrc_bias), bias))
        seen("tip", np.abs(d.site("tip").xpos - UP @ ours.at(zeta).get("tip.position", 3)).max())
        jacobian = np.zeros((2, 3, m.nv))
        mujoco.mj_jacSite(m, d, *jacobian, m.site("tip").id)
        seen("jacobian", relative(np.vstack([UP.T @ part @ G for part in jacobian]), J))
        seen("gears", relative([d.ten_velocity[0], *d.qvel[theirs.dofs(["rod_2", "rod_3"])]], gears * rates[:3]))
        np.testing.assert_allclose([d.ten_length[0] + m.numeric("x1_mid").data[0], d.joint("rod_2").qpos[0], d.joint("rod_3").qpos[0]], x, atol=1e-12)
        # With forces: half of what the actuators may give, and MuJoCo's own solver for the pins.
        most = m.actuator_ctrlrange[:, 1]
        d.ctrl[:] = most * np.random.default_rng(3).uniform(-0.5, 0.5, 6)
        mujoco.mj_forward(m, d)
        inputs = {f"f[{i + 1}]": d.ctrl[i] for i in range(3)} | {f"tau_wrist[{i + 1}]": d.ctrl[3 + i] for i in range(3)}
        expected = ours.at(zeta, rates, **inputs).get("zeta_ddot", 6)
        seen("soft", np.linalg.norm(d.qacc[theirs.zeta_dofs] - expected) / np.linalg.norm(expected))
        d.ctrl[:] = 0
    print(name, {what: f"{value:.1e}" for what, value in worst.items()})
    soft = worst.pop("soft")
    assert all(value < RELATIVE for value in worst.values()), worst
    assert soft < 2e-3


@pytest.mark.parametrize("name", MACHINES)
def test_the_keyframe_holds_and_limits_are_the_machine_s(files, hdrm, name):
    file, machine, path, _ = files[name]
    theirs, limits = Theirs(path), machine["limits"]
    m, d = theirs.m, theirs.d
    mujoco.mj_resetDataKeyframe(m, d, m.key("start").id)
    ours = Ours(hdrm, file).at(machine["start"]["zeta"])
    np.testing.assert_allclose(d.qpos[theirs.zeta_dofs], machine["start"]["zeta"], rtol=0, atol=1e-12)
    np.testing.assert_allclose(d.ctrl, [*ours.get("f_hold", 3), *ours.get("tau_hold", 3)], rtol=1e-9, atol=1e-6)
    mujoco.mj_forward(m, d)
    start = d.site("tip").xpos.copy()
    for _ in range(4000):
        mujoco.mj_step(m, d)
    moved = np.linalg.norm(d.site("tip").xpos - start)
    print(f"{name}: after 1 s the tip is {1e6 * moved:.2f} um from where it was")
    assert moved < 5e-5 and d.ncon == 0
    assert list(m.dof_damping[theirs.zeta_dofs]) == machine["joint_viscous"] and m.dof_damping.sum() == sum(machine["joint_viscous"])
    expected = np.radians([limits["zeta_min_deg"], limits["zeta_max_deg"]]).T
    np.testing.assert_allclose([m.joint(name).range for name in JOINTS], expected, rtol=1e-14)
    assert [list(m.joint(f"rod_{i}").range) for i in (2, 3)] == [limits["stroke_2"], limits["stroke_3"]]
    np.testing.assert_allclose(m.tendon_range[0] + machine["geometry"]["x1_mid"], limits["stroke_1"], atol=1e-12)
    named = [joint for joint in range(m.njnt) if m.jnt_limited[joint]]
    assert {m.joint(joint).name for joint in named} == {*JOINTS, "rod_2", "rod_3"}
    assert [m.actuator(i).name for i in range(m.nu)] == ["f_1", "f_2", "f_3", "tau_wrist_1", "tau_wrist_2", "tau_wrist_3"]
    assert list(m.actuator_ctrlrange[3:, 1]) == limits["tau_wrist_max"] and all(m.actuator_ctrllimited)
    drawn_bodies = {m.body(m.geom_bodyid[geom]).name for geom in range(m.ngeom)}
    assert drawn_bodies >= set(machine["bodies"]) - {"A4", "C4"}


@pytest.mark.parametrize("name", MACHINES)
def test_urdf_is_the_same_tree(files, hdrm, name):
    """Pinocchio's masses, poses, mass matrix and bias are those of MuJoCo's tree, which the test above ties to Hdrm."""
    file, machine, mjcf, path = files[name]
    theirs = Theirs(mjcf)
    m, d = theirs.m, theirs.d
    model = pinocchio.buildModelFromUrdf(str(path))
    data = model.createData()
    joints = list(model.names)[1:]
    assert set(joints) == {m.joint(i).name for i in range(m.njnt)} and model.nq == m.nq
    frames = {frame.name: i for i, frame in enumerate(model.frames)}
    total = sum(body["mass"] for body in machine["bodies"].values())
    assert pinocchio.computeTotalMass(model) == pytest.approx(total, rel=1e-14)
    for zeta, rates in drawn(machine, Ours(hdrm, file)):
        values = joint_values(machine, zeta)
        theirs.place(values)
        q, v = np.zeros(model.nq), np.random.default_rng(1).uniform(-0.5, 0.5, model.nv)
        for joint in joints:
            q[model.joints[model.getJointId(joint)].idx_q] = values[joint]
            assert model.lowerPositionLimit[model.joints[model.getJointId(joint)].idx_q] <= values[joint] + 1e-3, joint
            assert model.upperPositionLimit[model.joints[model.getJointId(joint)].idx_q] >= values[joint] - 1e-3, joint
        dofs = theirs.dofs(joints)
        order = [model.joints[model.getJointId(joint)].idx_v for joint in joints]
        d.qvel[dofs] = v[order]
        mujoco.mj_forward(m, d)
        pinocchio.framesForwardKinematics(model, data, q)
        for body, T in poses(machine, zeta)[0].items():
            found = data.oMf[frames[body]].homogeneous
            np.testing.assert_allclose(found, np.block([[UP @ T[:3, :3], (UP @ T[:3, 3])[:, None]], [np.zeros((1, 3)), 1.0]]), atol=1e-12)
        np.testing.assert_allclose(data.oMf[frames["tip"]].translation, d.site("tip").xpos, atol=1e-12)
        full = np.zeros((m.nv, m.nv))
        mujoco.mj_fullM(m, d, full)
        M = pinocchio.crba(model, data, q)
        M = np.triu(M) + np.triu(M, 1).T
        bias = pinocchio.nonLinearEffects(model, data, q, v)
        assert relative(M[np.ix_(order, order)], full[np.ix_(dofs, dofs)]) < RELATIVE
        assert relative(bias[order], d.qfrc_bias[dofs]) < RELATIVE


@pytest.mark.parametrize("name", MACHINES)
def test_inertias_are_those_of_the_file_to_the_last_digit(files, name):
    """Light bodies too, which the largest entry of a mass matrix hides."""
    _, machine, mjcf, urdf = files[name]
    order = ("xx", "yy", "zz", "xy", "xz", "yz")
    numbers = lambda element, key: [float(word) for word in element.get(key).split()]
    expected = {body: ([v["mass"]], v["com"], [v["inertia_com"][k] for k in order]) for body, v in machine["bodies"].items()}
    found = {}
    for body in ET.parse(mjcf).getroot().iter("body"):
        own = body.find("inertial")
        found[body.get("name")] = numbers(own, "mass"), numbers(own, "pos"), numbers(own, "fullinertia")
    assert found == expected
    tree, found = ET.parse(urdf).getroot(), {}
    for link in (link for link in tree.iter("link") if link.find("inertial") is not None):
        mass, origin, inertia = (link.find(f"inertial/{part}") for part in ("mass", "origin", "inertia"))
        assert numbers(origin, "rpy") == [0, 0, 0]
        found[link.get("name")] = numbers(mass, "value"), numbers(origin, "xyz"), [float(inertia.get(f"i{k}")) for k in order]
    assert found == expected
    damping = {joint.get("name"): float(joint.find("dynamics").get("damping")) for joint in tree.iter("joint") if joint.get("type") != "fixed"}
    assert damping == dict.fromkeys(damping, 0.0) | dict(zip(JOINTS, machine["joint_viscous"]))


def test_the_urdf_says_what_a_tree_loses(files):
    """The numbers in its head close the loops: the pins coincide at the start values that stand there."""
    _, machine, _, path = files["reference"]
    head = path.read_text().split("-->")[0]
    for name in ("cylinder_2", "rod_2", "cylinder_3", "rod_3", "rocker", "coupler"):
        assert head.count(name) >= 2, name
    words = dict(word.split("=") for word in head.split() if "=" in word[1:])
    values = joint_values(machine, machine["start"]["zeta"])
    assert {name: float(value) for name, value in words.items()} == pytest.approx(values, abs=1e-12)
    at = poses(machine, machine["start"]["zeta"])[0]
    pins = [line.split() for line in head.splitlines() if line.startswith("  x = ")]
    assert len(pins) == 3
    for _, _, a, _, rod, _, _, _, b, _, other in pins:
        place = lambda body, x: (at[body] @ [float(x), 0, 0, 1])[:3]
        np.testing.assert_allclose(place(rod, a), place(other, b), atol=1e-12)
    root = ET.parse(path).getroot()
    assert not list(root.iter("mimic")) and {link.get("name") for link in root.iter("link")} == {"base", "tip", *machine["bodies"]}
    limits = {joint.get("name"): joint.find("limit") for joint in root.iter("joint") if joint.get("type") != "fixed"}
    gears = [[float(limits[name].get(key)) for key in ("effort", "velocity")] for name in ("zeta_1", "rod_2", "rod_3")]
    assert gears == [[70e3 * 0.35, 0.07 / 0.35], [70e3, 0.07], [70e3, 0.07]]


def test_mistakes_are_named(tmp_path):
    bad = tmp_path / "bad.json"
    bad.write_text(json.dumps({"extends": "reference", "geometry": {"d4": 0.05, "d5": 0.05}}))
    out = tmp_path / "out.xml"
    for words, code, part in [
        (["reference"], 2, "<--mjcf <FILE>|--urdf <FILE>>"),
        (["reference", "--mjcf", out, "--urdf", out], 2, "cannot be used with"),
        (["reference", "--mjcf", tmp_path / "absent" / "a.xml"], 1, "absent"),
        (["no_such_machine", "--mjcf", out], 1, "must be a shipped machine"),
        ([bad, "--urdf", out], 1, "the four-bar does not close"),
    ]:
        done = call("hdrm-fmu", "machine", "export", *words)
        assert done.returncode == code and part in done.stderr and not out.exists(), done.stderr


def test_the_page_s_snippets_run(files, monkeypatch, tmp_path, capfd):
    """Each prints what it says: the lift rod goes out under 500 N more; the tip of the tree."""
    page = (ROOT / "docs/machine/robotics.md").read_text()
    snippets = [part.split("```")[0] for part in page.split("```python\n")[1:]]
    assert len(snippets) == 2
    _, machine, mjcf, urdf = files["reference"]
    (tmp_path / "mine.xml").write_text(mjcf.read_text())
    (tmp_path / "mine.urdf").write_text(urdf.read_text())
    monkeypatch.chdir(tmp_path)
    for snippet in snippets:
        exec(snippet, {})
    numbers = [float(word) for word in capfd.readouterr().out.replace("[", " ").replace("]", " ").split()]
    start = poses(machine, machine["start"]["zeta"])[1][1]
    tip = poses(machine, [0, 0.7, 0, 0, 0, 0])[0]["D4"] @ [*machine["geometry"]["r_D4_T4"], 1]
    assert start < numbers[0] < start + 0.05
    np.testing.assert_allclose(numbers[4:7], UP @ tip[:3], atol=1e-6)
    assert numbers[7] == pytest.approx(sum(body["mass"] for body in machine["bodies"].values()))
