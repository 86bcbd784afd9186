"""The MuJoCo model as a plant: forces in, the outputs of Hdrm.fmu by name out."""

import mujoco
import numpy as np
from mujoco_model import SUBSTEP, UP, mjcf

JOINTS = [f"zeta_{i}" for i in range(1, 7)]


class Plant:
    """The MuJoCo model with forces in and strokes out, at rest in the machine's start pose."""

    FORCED = ["zeta_1", "rod_2", "rod_3", "zeta_4", "zeta_5", "zeta_6"]

    def __init__(self, machine, scale=1.0, flexures=(), gravity=None, dry_friction=(0.0,) * 6):
        """`dry_friction`: of the six joints, N.m."""
        self.machine, self.flexures = machine, flexures
        self.m = mujoco.MjModel.from_xml_string(mjcf(machine, scale, flexures, gravity))
        self.m.jnt_limited[:] = self.m.tendon_limited[:] = 0  # no stops
        self.d = mujoco.MjData(self.m)
        self.rigid = mujoco.MjData(self.m)  # the same joints with no flexure bent
        dofs = lambda names: [self.m.joint(name).dofadr[0] for name in names]
        self.forced, self.free, self.rods = dofs(self.FORCED), dofs(JOINTS), dofs(["rod_2", "rod_3"])
        self.bent = dofs(flexure.name for flexure in flexures)
        self.arm = np.array([machine["geometry"]["r_B"], 1, 1, 1, 1, 1])
        self.tip, self.end = self.m.site("tip").id, self.m.body("D4").id
        self.loss = 0.0  # J, dissipated in joints and flexures since the start
        self.hold = self._hold()
        self.m.dof_frictionloss[self.free] = dry_friction
        self.damping, self.rubbing = self.m.dof_damping.copy(), np.flatnonzero(self.m.dof_frictionloss)
        self.apply(self.hold)
        mujoco.mj_forward(self.m, self.d)

    def apply(self, forces, wrench=(0.0,) * 6):
        """`wrench`: force and moment on the end-effector at the tip, in the tip's axes."""
        self.d.qfrc_applied[:] = 0
        if any(wrench):
            R = self.d.site_xmat[self.tip].reshape(3, 3)
            force, moment, at = R @ wrench[:3], R @ wrench[3:], self.d.site_xpos[self.tip]
            mujoco.mj_applyFT(self.m, self.d, force, moment, at, self.end, self.d.qfrc_applied)
        self.d.qfrc_applied[self.forced] += self.arm * forces

    def _hold(self):
        """Forces with which all accelerations vanish: these are affine in the forces. The flexures bend first until their springs
        carry what hangs on them; neither forces nor closed loops act across a flexure."""
        for _ in range(20):
            mujoco.mj_forward(self.m, self.d)
            self.d.qpos[self.bent] = -self.d.qfrc_bias[self.bent] / self.m.jnt_stiffness[self.bent]

        def acceleration(forces):
            self.apply(forces)
            mujoco.mj_forward(self.m, self.d)
            return self.d.qacc[self.free].copy()

        rest = acceleration(np.zeros(6))
        unit = np.array([1e4, 1e4, 1e4, 100, 100, 100])
        change = np.column_stack([(acceleration(u) - rest) for u in np.diag(unit)])
        return unit * np.linalg.solve(change, -rest)

    def step(self, forces, h, wrench=(0.0,) * 6):
        self.apply(forces, wrench)
        count = max(1, round(h / SUBSTEP))
        self.m.opt.timestep = h / count
        for _ in range(count):
            mujoco.mj_step(self.m, self.d)
            self.loss += h / count * self._dissipation()
        mujoco.mj_forward(self.m, self.d)

    def _dissipation(self):
        """Power, W, lost in the last substep, with the velocities that it ends with: those are what MuJoCo's dampers act on."""
        v, friction = self.d.qvel, self.d.efc_force[self.d.ne : self.d.ne + self.d.nf]
        return self.damping @ v**2 - friction @ v[self.rubbing]

    @property
    def zeta(self):
        return self.d.qpos[self.free]

    def strokes(self):
        """Strokes, m, and rod velocities, m/s; the slew moves a rack, the tendon x_1."""
        d, middle = self.d, self.m.numeric("x1_mid").data[0]
        return np.array([middle + d.ten_length[0], *d.qpos[self.rods]]), np.array([d.ten_velocity[0], *d.qvel[self.rods]])

    def rigid_tip(self):
        """Where the tip would be at these joint angles if nothing bent."""
        self.rigid.qpos[:] = self.d.qpos
        self.rigid.qpos[self.bent] = 0
        mujoco.mj_kinematics(self.m, self.rigid)
        return UP.T @ self.rigid.site_xpos[self.tip]

    def outputs(self):
        """Values of the interface of Hdrm.fmu, by name."""
        d = self.d
        x, x_dot = self.strokes()
        orientation, velocity = np.zeros(4), np.zeros(6)
        mujoco.mju_mat2Quat(orientation, (UP.T @ d.site_xmat[self.tip].reshape(3, 3)).ravel())
        mujoco.mj_objectVelocity(self.m, d, mujoco.mjtObj.mjOBJ_SITE, self.tip, velocity, 0)
        mujoco.mj_energyPos(self.m, d)
        mujoco.mj_energyVel(self.m, d)
        elastic = 0.5 * self.m.jnt_stiffness[self.bent] @ d.qpos[self.bent] ** 2
        return {
            "x": x,
            "x_dot": x_dot,
            "zeta": self.zeta,
            "zeta_dot": d.qvel[self.free],
            "zeta_ddot": d.qacc[self.free],
            "f_hold": self.hold[:3],
            "tip.position": UP.T @ d.site_xpos[self.tip],
            "tip.orientation": orientation,
            "tip.velocity": [*(UP.T @ velocity[3:]), *(UP.T @ velocity[:3])],
            "energy.kinetic": [d.energy[1]],
            "energy.potential": [d.energy[0] - elastic],
            "energy.elastic": [elastic],
            "energy.loss": [self.loss],
        }
