"""A world of which everything is known: scans are rays cast at the meshes of a scene from two known poses, with noise and with
what has moved in between. By Open3D of PyPI, whose RaycastingScene is Embree."""

from dataclasses import dataclass

import numpy
import open3d


@dataclass
class Pair:
    source: numpy.ndarray  # n x 3 metres, in the sensor's frame
    target: numpy.ndarray
    truth: numpy.ndarray  # 4 x 4, from the source's frame to the target's


@dataclass
class World:
    """What a sensor sees of scenes of a kind, each pair of scans in a scene of its own."""

    name: str
    scene: callable  # of a random generator: the meshes that stay, and pairs of where a mesh is at each scan
    rays: callable  # directions, n x 3, of length one
    noise: callable  # of ranges in metres: standard deviation along the ray
    farthest: float
    height: float  # of the sensor
    shift: float  # most between the scans, metres
    turn: float  # most about the vertical between the scans, degrees; a fifth of it about the others
    right: tuple  # metres and degrees: what is off by no more is right

    def pair(self, number):
        random = numpy.random.default_rng([sum(map(ord, self.name)), number])
        stays, moves = self.scene(random)
        first = pose((0, 0, self.height), turned(random.uniform(0, 360), "z"))
        between = pose(random.uniform(-1, 1, 3) * self.shift * (1, 0.3, 0.05),
                       turned(*[(random.uniform(-1, 1) * self.turn * share, axis)
                                for share, axis in ((1, "z"), (0.2, "y"), (0.2, "x"))]))
        clouds = [self.scan(stays + [at[when] for at in moves], sensor, random)
                  for when, sensor in enumerate((first, first @ between))]
        return Pair(clouds[1], clouds[0], between)

    def scan(self, meshes, sensor, random):
        scene = open3d.t.geometry.RaycastingScene()
        for mesh in meshes:
            scene.add_triangles(open3d.t.geometry.TriangleMesh.from_legacy(mesh))
        rays = self.rays()
        origins = numpy.broadcast_to(sensor[:3, 3], rays.shape)
        ranges = scene.cast_rays(numpy.hstack([origins, rays @ sensor[:3, :3].T]).astype("f4"))["t_hit"].numpy()
        seen = ranges < self.farthest
        if not seen.any():
            raise RuntimeError(f"no ray hit anything: Open3D {open3d.__version__} is not PyPI's")
        ranges = ranges[seen] + random.normal(size=seen.sum()) * self.noise(ranges[seen])
        return (rays[seen] * ranges[:, None]).astype("f4")


def turned(*turns):
    """Rotation by degrees about axes, one after another: turned(30, "z"), turned((30, "z"), (5, "x"))."""
    rotation = numpy.eye(3)
    for degrees, axis in (turns,) if numpy.isscalar(turns[0]) else turns:
        i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
        about = numpy.eye(3)
        about[i, i] = about[j, j] = numpy.cos(numpy.radians(degrees))
        about[j, i] = numpy.sin(numpy.radians(degrees))
        about[i, j] = -about[j, i]
        rotation = rotation @ about
    return rotation


def pose(translation, rotation):
    matrix = numpy.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, translation
    return matrix


def box(size, at, yaw=0):
    """Of which `at` is the middle of the lower face."""
    mesh = open3d.geometry.TriangleMesh.create_box(*size)
    mesh.translate((-size[0] / 2, -size[1] / 2, 0))
    return mesh.transform(pose(at, turned(yaw, "z")))


def ball(size, at):
    mesh = open3d.geometry.TriangleMesh.create_sphere(1, 12)
    return mesh.transform(pose(at, numpy.diag(size)))


def pole(radius, height, at):
    mesh = open3d.geometry.TriangleMesh.create_cylinder(radius, height, 12)
    return mesh.translate((at[0], at[1], at[2] + height / 2))


def relief(extent, step, heights):
    """A square of ground, `extent` to each side; heights of x and y."""
    places = numpy.arange(-extent, extent + step, step)
    x, y = numpy.meshgrid(places, places)
    vertices = numpy.stack([x, y, heights(x, y)], axis=-1).reshape(-1, 3)
    n = len(places)
    corner = (numpy.arange(n - 1)[:, None] * n + numpy.arange(n - 1)).ravel()
    faces = numpy.concatenate([numpy.stack([corner, corner + 1, corner + n], axis=1),
                               numpy.stack([corner + 1, corner + n + 1, corner + n], axis=1)])
    return open3d.geometry.TriangleMesh(open3d.utility.Vector3dVector(vertices), open3d.utility.Vector3iVector(faces))


def waves(random, height, length):
    """Heights of x and y: nine waves, none shorter than `length`."""
    directions = random.normal(size=(9, 2))
    directions *= (2 * numpy.pi / length / random.uniform(1, 6, 9) / numpy.linalg.norm(directions, axis=1))[:, None]
    phases = random.uniform(0, 2 * numpy.pi, 9)
    return lambda x, y: height / 3 * sum(numpy.sin(a * x + b * y + c) for (a, b), c in zip(directions, phases))


def street(random):
    """Houses along both sides, poles and trees before them, cars, of which those on the road move."""
    meshes = [relief(100, 2, waves(random, 0.05, 15))]
    moves = []
    for side in (-1, 1):
        x = random.uniform(-100, -90)
        while x < 100:
            wide, deep, high = random.uniform((8, 8, 4), (25, 14, 15))
            meshes.append(box((wide, deep, high), (x + wide / 2, side * (random.uniform(9, 13) + deep / 2), -0.5)))
            x += wide + random.choice([0, random.uniform(2, 12)])
        for x in numpy.arange(-90, 90, 18) + random.uniform(-5, 5, 10):
            if random.random() < 0.5:
                meshes.append(pole(0.1, 6, (x, side * 6.5, -0.2)))
            else:
                meshes += [pole(0.2, 2.5, (x, side * 7.5, -0.2)), ball(random.uniform(1, 2, 3), (x, side * 7.5, 3.5))]
        for x in numpy.arange(-80, 80, 8) + random.uniform(-1, 1, 20):
            if random.random() < 0.4:
                meshes += car((x, side * 4.8, 0.0))
        for x in numpy.arange(-60, 60, 15) + random.uniform(-4, 4, 8):
            if abs(x) > 6 and random.random() < 0.6:
                moves += list(zip(car((x, side * 1.8, 0.0)), car((x + side * random.uniform(0.5, 1.5), side * 1.8, 0.0))))
    return meshes, moves


def car(at):
    x, y, z = at
    return [box((4.3, 1.8, 0.7), (x, y, z + 0.3)), box((2.3, 1.6, 0.6), (x - 0.2, y, z + 1.0))]


def hills(random):
    """Ground without an edge, rocks and trees; nothing moves."""
    heights = waves(random, 3, 12)
    meshes = [relief(70, 1, lambda x, y: heights(x, y) - heights(0, 0))]
    for kind in range(90):
        x, y = random.uniform(-60, 60, 2)
        if x * x + y * y < 16:
            continue
        z = heights(x, y) - heights(0, 0)
        if kind % 3:
            meshes.append(ball(random.uniform(0.2, 1.2, 3), (x, y, z)))
        else:
            meshes += [pole(0.2, 3, (x, y, z - 0.5)), ball(random.uniform(0.8, 2, 3), (x, y, z + 3.5))]
    return meshes, []


def room(random):
    """Walls, furniture along them, things on it; somebody walks, and a chair is moved."""
    wide, deep = random.uniform(4, 7, 2)
    meshes = [box((wide, deep, 0.1), (0, 0, -0.1)), box((wide, deep, 0.1), (0, 0, 2.6))]
    for side in (-1, 1):
        meshes += [box((0.1, deep, 2.6), (side * wide / 2, 0, 0)), box((wide, 0.1, 2.6), (0, side * deep / 2, 0))]
        for along, across, is_x in ((wide, deep, True), (deep, wide, False)):
            for place in numpy.arange(-along / 2 + 0.5, along / 2 - 0.5, 1.1):
                size = random.uniform((0.4, 0.3, 0.4), (1.0, 0.6, 2.0))
                at = (place, side * (across / 2 - 0.4))
                if random.random() < 0.6:
                    at = at if is_x else at[::-1]
                    meshes.append(box(size if is_x else size[[1, 0, 2]], (*at, 0)))
                    meshes.append(ball(random.uniform(0.05, 0.2, 3), (*at, size[2] + 0.05)))
    somebody, chair = random.uniform(-1, 1, (2, 2)) * (wide / 2 - 1, deep / 2 - 1)
    steps = [(0, 0), random.uniform(-0.3, 0.3, 2)]
    moves = [[pole(0.2, 1.7, (*(somebody + step), 0)) for step in steps],
             [box((0.4, 0.4, 0.9), (*(chair + step), 0), 200 * step[0]) for step in steps]]
    # Who stands where the sensor is would be all that it sees.
    return meshes, [at for at, place in zip(moves, (somebody, chair)) if numpy.linalg.norm(place) > 0.8]


def spinning(beams=32, around=1024, lowest=-25, highest=15):
    elevation = numpy.radians(numpy.linspace(lowest, highest, beams))[:, None]
    azimuth = numpy.radians(numpy.arange(around) * 360 / around)[None, :]
    directions = numpy.cos(elevation) * numpy.cos(azimuth), numpy.cos(elevation) * numpy.sin(azimuth), \
        numpy.sin(elevation) + 0 * azimuth
    return numpy.stack(directions, axis=-1).reshape(-1, 3)


def camera(wide=213, high=160, across=70):
    """Looks along x, a little down."""
    at = numpy.tan(numpy.radians(across / 2)) * (2 * numpy.arange(wide) - wide + 1) / wide
    up = numpy.tan(numpy.radians(across / 2)) * (2 * numpy.arange(high) - high + 1) / wide
    y, z = numpy.meshgrid(at, up)
    directions = numpy.stack([numpy.ones_like(y), y, z], axis=-1).reshape(-1, 3) @ turned(10, "y").T
    return directions / numpy.linalg.norm(directions, axis=1, keepdims=True)


WORLDS = {world.name: world for world in (
    World("street", street, spinning, lambda ranges: 0.02, 80, 1.8, 1.5, 5, (0.1, 0.5)),
    World("hills", hills, spinning, lambda ranges: 0.02, 50, 1.8, 1.5, 5, (0.1, 0.5)),
    World("room", room, camera, lambda ranges: 0.0012 * ranges**2, 6, 1.4, 0.15, 5, (0.02, 0.5)),
)}
