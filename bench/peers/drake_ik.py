"""Drake's InverseKinematics with a minimum-distance constraint: the squared distance to the query is minimised from the query.

The robot is put together from the pinocchio model, joint by joint and shape by shape, so that both have the same geometry, limits and
pairs. The program is made once a scene; a query changes its cost and its start. Only that and the solver are timed."""
import time

import coal
import numpy as np
import pydrake.all as drake

# Distance below which a pair contributes to the constraint [m].
INFLUENCE = 0.05


class Drake:
    """Drake's solver from one start. Raises ValueError for shapes that are not convex, for which Drake would take their hulls."""

    def __init__(self, scene):
        self.scene = scene
        solvers = [drake.SnoptSolver(), drake.IpoptSolver(), drake.NloptSolver()]
        self.solver = next(s for s in solvers if s.available() and s.enabled())
        self.name = f"Drake, {type(self.solver).__name__.removesuffix('Solver').upper()}, from the query"
        builder = drake.DiagramBuilder()
        self.plant, self.graph = drake.AddMultibodyPlantSceneGraph(builder, 0.0)
        bodies = self.tree()
        ids = self.shapes(bodies)
        self.plant.Finalize()
        self.filters(ids)
        self.diagram = builder.Build()
        self.root = self.diagram.CreateDefaultContext()
        self.order = [self.plant.GetJointByName(name).position_start() for name in scene.joints]
        self.program()

    def tree(self):
        """Makes a body for each joint of the pinocchio model; the world stands for the first."""
        model, plant = self.scene.model, self.plant
        bodies = [plant.world_body()]
        inertia = drake.SpatialInertia(1.0, np.zeros(3), drake.UnitInertia.SolidSphere(0.1))
        for j in range(1, model.njoints):
            name, joint = model.names[j], model.joints[j]
            body, parent = plant.AddRigidBody(f"body of {name}", inertia), bodies[model.parents[j]]
            frame = plant.AddFrame(drake.FixedOffsetFrame(f"frame of {name}", parent.body_frame(), transform(model.jointPlacements[j])))
            data = joint.createData()
            joint.calc(data, np.array([1.0, 0.0]) if joint.nq == 2 else np.zeros(1))
            linear, angular = np.split(np.array(data.S).reshape(6), 2)
            low, high = (-np.inf, np.inf) if joint.nq == 2 else (model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q])
            turns = np.linalg.norm(angular) > 0
            kind = drake.RevoluteJoint if turns else drake.PrismaticJoint
            plant.AddJoint(kind(name, frame, body.body_frame(), angular if turns else linear, low, high))
            bodies.append(body)
        return bodies

    def shapes(self, bodies):
        friction, ids = drake.CoulombFriction(), []
        for k, g in enumerate(self.scene.geometry.geometryObjects):
            ids.append(self.plant.RegisterCollisionGeometry(bodies[g.parentJoint], transform(g.placement), shape(g, k), f"shape {k}", friction))
        return ids

    def filters(self, ids):
        """Restricts collision checks to exactly the pairs of the scene."""
        declared, manager = drake.CollisionFilterDeclaration(), self.graph.collision_filter_manager()
        declared.ExcludeWithin(drake.GeometrySet(ids))
        for p in self.scene.geometry.collisionPairs:
            declared.AllowBetween(drake.GeometrySet(ids[p.first]), drake.GeometrySet(ids[p.second]))
        manager.Apply(declared)

    def program(self):
        n = len(self.order)
        self.ik = drake.InverseKinematics(self.plant, self.plant.GetMyMutableContextFromRoot(self.root), True)
        self.ik.AddMinimumDistanceLowerBoundConstraint(self.scene.clearance, INFLUENCE)
        self.x = self.ik.q()[self.order]
        self.cost = self.ik.prog().AddQuadraticErrorCost(np.eye(n), np.zeros(n), self.x).evaluator()

    def solve(self, q):
        began = time.thread_time()
        self.cost.UpdateCoefficients(2 * np.eye(len(q)), -2 * q, q @ q, True)
        guess = np.zeros(len(self.order))
        guess[self.order] = q
        found = self.solver.Solve(self.ik.prog(), guess, None)
        witness = found.GetSolution(self.x) if found.is_success() else None
        return {"witness": witness, "seconds": time.thread_time() - began}


def transform(placement):
    return drake.RigidTransform(placement.homogeneous)


def shape(g, k):
    s = g.geometry
    if isinstance(s, coal.Box):
        return drake.Box(*(2 * s.halfSide))
    if isinstance(s, coal.Sphere):
        return drake.Sphere(s.radius)
    if isinstance(s, coal.Cylinder):
        return drake.Cylinder(s.radius, 2 * s.halfLength)
    if isinstance(s, coal.Capsule):
        return drake.Capsule(s.radius, 2 * s.halfLength)
    if isinstance(s, coal.ConvexBase):
        return drake.Convex(np.array([s.point(i) for i in range(s.num_points)]).T, f"hull {k}")
    raise ValueError(f"it takes raw meshes for their hulls, {g.name} among them")
