"""`Robot.from_usd`: stages that are made from URDF, in other units, frames and orders, have the labels of the URDF."""

import pathlib
import xml.etree.ElementTree as ET
from typing import Any, Dict, List, Tuple

import numpy as np
import pytest

import extricate
from extricate import Robot, Scene

pytest.importorskip("pxr", reason="usd-core is not installed")
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics  # noqa: E402

Array = Any
POSES = 2000


def turn(axis: Array, angle: float) -> Array:
    """Returns the transform of a rotation about an axis (Rodrigues)."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    out = np.eye(4)
    out[:3, :3] = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
    return out


def placed(xyz: Any, rpy: Any = (0, 0, 0)) -> Array:
    out = turn([0, 0, 1], rpy[2]) @ turn([0, 1, 0], rpy[1]) @ turn([1, 0, 0], rpy[0])
    out[:3, 3] = xyz
    return out


def origin(element: Any) -> Array:
    found = element.find("origin")
    if found is None:
        return np.eye(4)
    numbers = [[float(x) for x in found.get(name, "0 0 0").split()] for name in ("xyz", "rpy")]
    return placed(*numbers)


def to_z(axis: Array) -> Array:
    """Returns a rotation that takes z to an axis."""
    axis = np.asarray(axis) / np.linalg.norm(axis)
    across = np.cross([0, 0, 1], axis)
    if np.linalg.norm(across) < 1e-9:
        return np.eye(4) if axis[2] > 0 else turn([1, 0, 0], np.pi)
    return turn(across, float(np.arccos(np.clip(axis[2], -1, 1))))


def read_mesh(path: pathlib.Path) -> Tuple[Array, List[List[int]]]:
    """Reads the corners and faces of an OBJ or a binary STL file."""
    if path.suffix == ".stl":
        record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        corners = np.frombuffer(path.read_bytes()[84:], record)["corners"].reshape(-1, 3)
        return corners, np.arange(len(corners)).reshape(-1, 3).tolist()
    lines = [line.split() for line in path.read_text().splitlines()]
    faces = [[int(x) - 1 for x in line[1:]] for line in lines if line[:1] == ["f"]]
    return np.array([[float(x) for x in line[1:4]] for line in lines if line[:1] == ["v"]]), faces


class Writer:
    """Writes a URDF as a stage: bodies beside each other with frames of their own, lengths in another unit, joints in both directions."""

    def __init__(self, urdf: str, path: pathlib.Path, unit: float, rng: Any) -> None:
        self.rng, self.unit, self.folder = rng, unit, path.parent
        self.stage = Usd.Stage.CreateNew(str(path))
        UsdGeom.SetStageMetersPerUnit(self.stage, unit)
        UsdGeom.SetStageUpAxis(self.stage, UsdGeom.Tokens.z)
        self.root = UsdGeom.Xform.Define(self.stage, "/robot")
        self.stage.SetDefaultPrim(self.root.GetPrim())
        # The whole robot may be scaled, as assets are.
        self.scale = float(rng.choice([1.0, 0.1]))
        self.root.AddScaleOp().Set(Gf.Vec3f(self.scale))
        self.robot = ET.fromstring(urdf)
        joints = self.robot.findall("joint")
        below = {joint.find("child").get("link"): joint for joint in joints}  # type: ignore[union-attr]
        self.poses: Dict[str, Array] = {}
        self.own: Dict[str, Array] = {}
        for link in self.robot.findall("link"):
            name = link.get("name", "")
            self.own[name] = placed(rng.uniform(-0.1, 0.1, 3), rng.uniform(-2, 2, 3))
            pose, at = np.eye(4), name
            while at in below:
                pose, at = origin(below[at]) @ pose, below[at].find("parent").get("link")  # type: ignore[union-attr, assignment]
            self.poses[name] = pose
        for link in self.robot.findall("link"):
            self.body(link)
        for joint in joints:
            self.joint(joint)
        (top,) = [link.get("name", "") for link in self.robot.findall("link") if link.get("name") not in below]
        fixed = UsdPhysics.FixedJoint.Define(self.stage, "/robot/hold")
        fixed.CreateBody1Rel().SetTargets([Sdf.Path(f"/robot/{top}")])
        self.frame(fixed, 1, np.linalg.inv(self.own[top]))
        self.stage.GetRootLayer().Save()

    def place(self, prim: Any, pose: Array, scale: Any = (1, 1, 1)) -> None:
        """Gives a prim a pose [m] in its parent, and a scale."""
        matrix = pose.copy()
        matrix[:3, 3] /= self.unit * self.scale
        matrix[:3, :3] = matrix[:3, :3] * np.asarray(scale, dtype=float)
        prim.AddTransformOp().Set(Gf.Matrix4d(*matrix.T.ravel().tolist()))

    def body(self, link: Any) -> None:
        name = link.get("name")
        body = UsdGeom.Xform.Define(self.stage, f"/robot/{name}")
        UsdPhysics.RigidBodyAPI.Apply(body.GetPrim())
        self.place(body, self.poses[name] @ self.own[name])
        for number, collision in enumerate(link.findall("collision")):
            geometry = collision.find("geometry")[0]
            pose = np.linalg.inv(self.own[name]) @ origin(collision)
            self.shape(geometry, f"/robot/{name}/part{number}", pose)

    def shape(self, geometry: Any, path: str, pose: Array) -> None:
        unit = self.unit * self.scale
        number = {name: [float(x) for x in text.split()] for name, text in geometry.attrib.items() if name != "filename"}
        axis = str(self.rng.choice(["X", "Y", "Z"]))
        along = {"X": [1, 0, 0], "Y": [0, 1, 0], "Z": [0, 0, 1]}[axis]
        if geometry.tag == "box":
            made = UsdGeom.Cube.Define(self.stage, path)
            made.CreateSizeAttr(2.0)
            self.place(made, pose, np.array(number["size"]) / 2 / unit)
        elif geometry.tag == "sphere":
            made = UsdGeom.Sphere.Define(self.stage, path)
            made.CreateRadiusAttr(number["radius"][0] / unit)
            self.place(made, pose)
        elif geometry.tag in ("cylinder", "capsule"):
            made = (UsdGeom.Cylinder if geometry.tag == "cylinder" else UsdGeom.Capsule).Define(self.stage, path)
            made.CreateRadiusAttr(number["radius"][0] / unit)
            made.CreateHeightAttr(number["length"][0] / unit)
            made.CreateAxisAttr(axis)
            self.place(made, pose @ np.linalg.inv(to_z(along)))
        else:
            made = UsdGeom.Mesh.Define(self.stage, path)
            corners, faces = read_mesh(self.folder / geometry.get("filename").replace("package://", ""))
            points = [[float(x) / unit for x in corner] for corner in corners]
            made.CreatePointsAttr([Gf.Vec3f(*point) for point in points])
            made.CreateFaceVertexCountsAttr([len(face) for face in faces])
            # Half of the meshes are mirrored: the transform mirrors them back.
            is_mirrored = bool(self.rng.random() < 0.5)
            made.CreateFaceVertexIndicesAttr([corner for face in faces for corner in face])
            if is_mirrored:
                made.GetPointsAttr().Set([Gf.Vec3f(-point[0], point[1], point[2]) for point in points])
                made.CreateOrientationAttr(UsdGeom.Tokens.leftHanded)
            self.place(made, pose, [-1, 1, 1] if is_mirrored else [1, 1, 1])
            UsdPhysics.MeshCollisionAPI.Apply(made.GetPrim()).CreateApproximationAttr("convexHull")
        UsdPhysics.CollisionAPI.Apply(made.GetPrim())

    def frame(self, joint: Any, number: int, pose: Array) -> None:
        """Sets the frame of a joint in a body."""
        quaternion = Gf.Matrix3d(*pose[:3, :3].T.ravel().tolist()).ExtractRotation().GetQuat()
        position = Gf.Vec3f(*(pose[:3, 3] / self.unit / self.scale).tolist())
        for name, value in (("Pos", position), ("Rot", Gf.Quatf(quaternion))):
            getattr(joint, f"CreateLocal{name}{number}Attr")(value)

    def joint(self, joint: Any) -> None:
        kind, path = joint.get("type"), f"/robot/joints/{joint.get('name')}"
        parent, child = (joint.find(tag).get("link") for tag in ("parent", "child"))
        axis = [float(x) for x in joint.find("axis").get("xyz").split()] if joint.find("axis") is not None else [1.0, 0, 0]
        letter = str(self.rng.choice(["X", "Y", "Z"]))
        # The joint's own frame: its letter points along the axis.
        own = to_z(axis) @ np.linalg.inv(to_z({"X": [1, 0, 0], "Y": [0, 1, 0], "Z": [0, 0, 1]}[letter]))
        is_swapped = bool(self.rng.random() < 0.5)
        if is_swapped:
            # Body 0 is the child then: its motion is the inverse, so the axis points the other way.
            own = own @ turn({"X": [0, 1, 0], "Y": [0, 0, 1], "Z": [1, 0, 0]}[letter], np.pi)
        made = {"fixed": UsdPhysics.FixedJoint, "prismatic": UsdPhysics.PrismaticJoint}.get(kind, UsdPhysics.RevoluteJoint).Define(self.stage, path)
        if kind != "fixed":
            made.CreateAxisAttr(letter)
        if kind in ("revolute", "prismatic"):
            limit = joint.find("limit")
            factor = 180 / np.pi if kind == "revolute" else 1 / self.unit
            made.CreateLowerLimitAttr(float(limit.get("lower")) * factor)
            made.CreateUpperLimitAttr(float(limit.get("upper")) * factor)
        mimic = joint.find("mimic")
        if mimic is not None:
            prim = made.GetPrim()
            prim.CreateRelationship("newton:mimicJoint").SetTargets([Sdf.Path(f"/robot/joints/{mimic.get('joint')}")])
            prim.CreateAttribute("newton:mimicCoef0", Sdf.ValueTypeNames.Float).Set(np.rad2deg(float(mimic.get("offset"))))
            prim.CreateAttribute("newton:mimicCoef1", Sdf.ValueTypeNames.Float).Set(float(mimic.get("multiplier")))
        frames = [np.linalg.inv(self.own[parent]) @ origin(joint) @ own, np.linalg.inv(self.own[child]) @ own]
        bodies = [parent, child]
        for number in (0, 1):
            end = 1 - number if is_swapped else number
            relation = made.CreateBody0Rel() if number == 0 else made.CreateBody1Rel()
            relation.SetTargets([Sdf.Path(f"/robot/{bodies[end]}")])
            self.frame(made, number, frames[end])


WEDGE = "v 0 0 0\nv 0.2 0 0\nv 0 0.15 0\nv 0 0 0.1\nv 0.2 0.15 0\nf 1 3 5 2\nf 1 2 4\nf 1 4 3\nf 2 5 4\nf 5 3 4\n"


def drawn(rng: Any, folder: pathlib.Path) -> str:
    """Draws a robot: a tree of links with shapes of all kinds, and joints of all kinds."""
    (folder / "wedge.obj").write_text(WEDGE)

    def numbers(low: float, high: float, count: int) -> str:
        return " ".join(f"{x:.4f}" for x in rng.uniform(low, high, count))

    def place(reach: float) -> str:
        return f'<origin xyz="{numbers(-reach, reach, 3)}" rpy="{numbers(-2, 2, 3)}"/>'

    out = ""
    for link in range(int(rng.integers(4, 8))):
        shapes = ""
        for _ in range(int(rng.integers(1, 3))):
            kind = rng.choice(["box", "sphere", "cylinder", "capsule", "mesh"])
            sizes = {
                "box": f'size="{numbers(0.05, 0.2, 3)}"',
                "sphere": f'radius="{numbers(0.03, 0.1, 1)}"',
                "mesh": f'filename="{folder / "wedge.obj"}"',
            }.get(kind, f'radius="{numbers(0.03, 0.06, 1)}" length="{numbers(0.05, 0.2, 1)}"')
            shapes += f"<collision>{place(0.1)}<geometry><{kind} {sizes}/></geometry></collision>"
        out += f'<link name="link{link}">{shapes}</link>'
        if link:
            kind = rng.choice(["revolute", "revolute", "prismatic", "continuous", "fixed"])
            limits = {"revolute": ("-2.5", "2"), "prismatic": ("-0.1", "0.3")}.get(kind)
            limit = f'<limit lower="{limits[0]}" upper="{limits[1]}"/>' if limits else ""
            out += (
                f'<joint name="joint{link}" type="{kind}"><parent link="link{rng.integers(0, link)}"/><child link="link{link}"/>'
                f'{place(0.3)}<axis xyz="{numbers(0.1, 1, 3)}"/>{limit}</joint>'
            )
    return f'<robot name="drawn">{out}</robot>'


def compared(urdf: str, path: pathlib.Path, table: List[Any], rng: Any) -> Tuple[int, int]:
    """Returns how many of POSES collide in the scene of the URDF, and how many labels differ in that of the stage."""
    first = Scene(Robot(urdf, geometry="convex-hull"), table)
    second = Scene(Robot.from_usd(path), table)
    assert {joint.name: joint.kind for joint in first.joints} == {joint.name: joint.kind for joint in second.joints}
    assert sorted(map(sorted, first.pairs)) == sorted(map(sorted, second.pairs))
    # Limits of a stage have seven digits.
    Q = first.lower + (first.upper - first.lower) * rng.uniform(1e-6, 1 - 1e-6, (POSES, first.nq))
    where = {joint.name: joint.start for joint in first.joints}
    order = [where[joint.name] for joint in second.joints]
    labels, theirs = first.check(Q), second.check(Q[:, order])
    distances = first.distances(Q)
    assert np.abs(distances - second.distances(Q[:, order])).max() < 3e-6
    # Frames of a stage have seven digits too.
    return int((~labels).sum()), int(((labels != theirs) & (np.abs(distances - first.clearance) > 3e-6)).sum())


@pytest.mark.parametrize("seed", range(20))
def test_labels_are_those_of_the_urdf(seed: int, tmp_path: pathlib.Path) -> None:
    rng = np.random.default_rng(seed)
    urdf = drawn(rng, tmp_path)
    path = tmp_path / ("robot.usda" if seed % 2 else "robot.usdc")
    Writer(urdf, path, float(rng.choice([1.0, 0.01, 0.001])), rng)
    table = [extricate.Box([2, 2, 0.1], [0, 0, -0.25], "table")]
    colliding, differing = compared(urdf, path, table, rng)
    assert 0 < colliding and differing == 0


@pytest.mark.parametrize("name", ["planar-arm", "shelf-arm", "hand"])
def test_built_in_robots(name: str, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for file, content in Scene.builtin_files(name).items():
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_bytes(content)
    urdf = next((tmp_path / "robot").glob("*.urdf")).read_text()
    rng = np.random.default_rng(1)
    Writer(urdf, tmp_path / "robot.usda", 0.01, rng)
    colliding, differing = compared(urdf, tmp_path / "robot.usda", [extricate.Box([0.05, 0.05, 2], [0.1, 0.05, 0], "post")], rng)
    assert 0 < colliding < POSES and differing == 0


ARM = """#usda 1.0
(
    defaultPrim = "arm"
    metersPerUnit = 0.01
    upAxis = "Z"
)
def Xform "arm" (
    prepend apiSchemas = ["PhysicsArticulationRootAPI", "PhysicsFilteredPairsAPI"]
)
{
    def Xform "base" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI"]
    )
    {
        def Cube "shape" (
            prepend apiSchemas = ["PhysicsCollisionAPI"]
        )
        {
            double size = 10
        }
    }
    def Xform "upper" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI"]
    )
    {
        double3 xformOp:translate = (0, 0, 30)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        def Capsule "shape" (
            prepend apiSchemas = ["PhysicsCollisionAPI"]
        )
        {
            double radius = 2
            double height = 20
            token axis = "Z"
        }
    }
    def Xform "hand" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsFilteredPairsAPI"]
    )
    {
        double3 xformOp:translate = (0, 0, 60)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        rel physics:filteredPairs = </arm/base>
        def Sphere "shape" (
            prepend apiSchemas = ["PhysicsCollisionAPI"]
        )
        {
            double radius = 3
        }
    }
    def PhysicsRevoluteJoint "shoulder"
    {
        rel physics:body0 = </arm/base>
        rel physics:body1 = </arm/upper>
        point3f physics:localPos0 = (0, 0, 10)
        point3f physics:localPos1 = (0, 0, -20)
        uniform token physics:axis = "Y"
        float physics:lowerLimit = -90
        float physics:upperLimit = 90
    }
    def PhysicsPrismaticJoint "slide"
    {
        rel physics:body0 = </arm/upper>
        rel physics:body1 = </arm/hand>
        point3f physics:localPos0 = (0, 0, 30)
        uniform token physics:axis = "Z"
        LIMITS
        bool physics:collisionEnabled = 1
    }
}
def Cube "wall" (
    prepend apiSchemas = ["PhysicsCollisionAPI"]
)
{
    double size = 10
    double3 xformOp:translate = (40, 0, 40)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Plane "floor" (
    prepend apiSchemas = ["PhysicsCollisionAPI"]
)
{
    token axis = "Z"
    double3 xformOp:translate = (0, 0, -20)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Sphere "hidden" (
    prepend apiSchemas = ["PhysicsCollisionAPI"]
)
{
    bool physics:collisionEnabled = 0
    double radius = 900
}
"""
LIMITS = "float physics:lowerLimit = 0\n        float physics:upperLimit = 20"


def test_units_pairs_and_obstacles(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "arm.usda"
    path.write_text(ARM.replace("LIMITS", LIMITS))
    scene = Scene(Robot.from_usd(path))
    assert sorted(scene.bodies) == ["base", "floor", "hand", "upper", "wall"]
    assert [joint.name for joint in scene.joints] == ["shoulder", "slide"]
    assert scene.lower == pytest.approx([-np.pi / 2, 0]) and scene.upper == pytest.approx([np.pi / 2, 0.2])
    pairs = {frozenset(pair) for pair in scene.pairs}
    assert frozenset(("hand", "base")) not in pairs, "filtered"
    assert frozenset(("upper", "hand")) in pairs, "checked, although a joint joins them"
    assert frozenset(("base", "upper")) not in pairs and frozenset(("hand", "wall")) in pairs
    poses = scene.poses([np.pi / 2, 0.1])
    # The hand is 0.5 m above the shoulder, which is 0.1 m above the base, and 0.1 m farther out on the slide.
    place = poses[scene.bodies.index("hand")]
    corners = scene.mesh("hand")[0] @ place[:3, :3].T + place[:3, 3]
    assert (corners.min(axis=0) + corners.max(axis=0)) / 2 == pytest.approx([0.6, 0, 0.1], abs=1e-6)
    # Between the hand and the side of the wall at 0.35 m.
    names = [set(pair) for pair in scene.pairs]
    gap = scene.pair_distances([[0.0, 0.0]])[0][names.index({"hand", "wall"})]
    assert gap == pytest.approx(np.hypot(0.35, 0.15) - 0.03, abs=1e-6)
    assert extricate.Scene(Robot.from_usd(Usd.Stage.Open(str(path)))).pairs == scene.pairs


def test_names_that_usd_does_not_have_are_those_of_the_display(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "arm.usda"
    path.write_text(ARM.replace("LIMITS", LIMITS).replace('PhysicsPrismaticJoint "slide"', 'PhysicsPrismaticJoint "tn__slide1_b" (\n displayName = "slide.1"\n)'))
    assert [joint.name for joint in Scene(Robot.from_usd(path)).joints] == ["shoulder", "slide.1"]


def test_what_a_urdf_cannot_express_is_an_error(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "arm.usda"
    path.write_text(ARM.replace("LIMITS", ""))
    with pytest.raises(ValueError, match=r'slide: got limits of -inf to inf, expected finite ones, or Robot.from_usd\(path, limits'):
        Robot.from_usd(path)
    assert Scene(Robot.from_usd(path, limits={"slide": (0, 0.1)})).upper[1] == 0.1
    path.write_text(ARM.replace("LIMITS", LIMITS).replace('PhysicsPrismaticJoint "slide"', 'PhysicsDistanceJoint "slide"'))
    with pytest.raises(ValueError, match="/arm/slide: got a PhysicsDistanceJoint, expected a revolute"):
        Robot.from_usd(path)
    path.write_text(ARM[: ARM.index("def Xform")] + ARM[ARM.index('def Cube "wall"') :])
    with pytest.raises(ValueError, match="arm.usda: got no rigid body"):
        Robot.from_usd(path)
    path.write_text("no stage")
    with pytest.raises(ValueError, match="arm.usda: .*expected a stage of USD"):
        Robot.from_usd(path)
    with pytest.raises(ValueError, match="none.usda"):
        Robot.from_usd(tmp_path / "none.usda")


def test_what_is_left_out_is_warned_of(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "arm.usda"
    loop = """def PhysicsFixedJoint "loop"
    {
        bool physics:excludeFromArticulation = 1
        rel physics:body0 = </arm/base>
        rel physics:body1 = </arm/hand>
    }
    def PhysicsRevoluteJoint"""
    path.write_text(ARM.replace("LIMITS", LIMITS).replace("def PhysicsRevoluteJoint", loop, 1))
    with pytest.warns(UserWarning, match="from_usd: the joint /arm/loop closes a loop"):
        assert Scene(Robot.from_usd(path)).nq == 2
    path.write_text(ARM.replace("LIMITS", LIMITS).replace('def Sphere "shape"', 'def Cone "shape"'))
    with pytest.warns(UserWarning, match="from_usd: the Cone /arm/hand/shape is left out"):
        Robot.from_usd(path)
    box = ARM[ARM.index('    def Xform "base"') : ARM.index('    def Xform "upper"')].replace("base", "box").replace("shape", "side")
    path.write_text(ARM.replace("LIMITS", LIMITS) + box)
    with pytest.warns(UserWarning, match="from_usd: the body /box has no joint, and is an obstacle"):
        assert "side" in Scene(Robot.from_usd(path)).bodies
